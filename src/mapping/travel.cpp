#include "loopstone/mapping/travel.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "loopstone/grid/block_grid.hpp"
#include "mapping/scan_drawing.hpp"
#include "mapping/shared_grid.hpp"

namespace loopstone {

namespace {

/// Of the side of a cell: a point of it may lie so far from its centre.
constexpr double kHalfDiagonal = 0.71;
/// A footprint is drawn anew once it moved by so much of a cell.
constexpr double kStepCells = 0.5;

/// A cell that a drive is coming by, or came by last.
struct OpenPass {
  double left_m = -1.0;  ///< the drive's way when it was over the cell last; below 0: never
  float way_m = 0.0F;    ///< of this pass, while it moved
  float time_s = 0.0F;
};

void close(const OpenPass& pass, CellTravel& cell) {
  constexpr std::uint16_t kMost = std::numeric_limits<std::uint16_t>::max();
  if (cell.passes == kMost) return;
  ++cell.passes;
  if (!(pass.time_s > 0.0F)) return;
  ++cell.timed;
  cell.speed_sum_m_s += pass.way_m / pass.time_s;
}

/// Part of a path without a gap.
using Run = std::span<const StampedPose2>;

std::vector<Run> runs_of(const Trajectory& path) {
  const Run all(path.poses());
  std::vector<Run> runs;
  std::size_t first = 0;
  for (std::size_t i = 1; i <= all.size(); ++i) {
    const bool goes_on =
        i < all.size() &&
        (all[i].pose.translation() - all[i - 1].pose.translation()).norm() <= kTravel.gap_m &&
        (all[i].stamp - all[i - 1].stamp).seconds() <= kTravel.gap_s;
    if (goes_on) continue;
    runs.push_back(all.subspan(first, i - first));
    first = i;
  }
  return runs;
}

/// At each pose but the last, to the next one [m/s]: from the first pose to the last one that lie
/// within the window around it.
std::vector<double> speeds_of(Run run) {
  std::vector<double> speeds;
  const Duration half = Duration::from_seconds(0.5 * kTravel.speed_window_s);
  std::size_t first = 0;
  std::size_t last = 0;
  for (std::size_t i = 0; i + 1 < run.size(); ++i) {
    while (first < i && run[first].stamp + half < run[i].stamp) ++first;
    last = std::max(last, i + 1);
    while (last + 1 < run.size() && run[last + 1].stamp <= run[i + 1].stamp + half) ++last;
    const double way_m = (run[last].pose.translation() - run[first].pose.translation()).norm();
    speeds.push_back(way_m / (run[last].stamp - run[first].stamp).seconds());
  }
  return speeds;
}

/// One drive over the floor.
class Passage {
 public:
  Passage(double resolution_m, double reach_m)
      : plane_{.resolution = resolution_m}, reach_m_(reach_m), open_(resolution_m) {}

  template <typename Close>
  void drive(Run run, Close&& closed) {
    const std::vector<double> speeds = speeds_of(run);
    Eigen::Vector2d from = run.front().pose.translation();
    sweep(from, from, {}, closed);
    OpenPass step;
    for (std::size_t i = 0; i < speeds.size(); ++i) {
      const double time_s = (run[i + 1].stamp - run[i].stamp).seconds();
      if (speeds[i] >= kTravel.standing_m_s) {
        step.way_m += static_cast<float>(speeds[i] * time_s);
        step.time_s += static_cast<float>(time_s);
      }
      const Eigen::Vector2d to = run[i + 1].pose.translation();
      const bool ends = i + 1 == speeds.size();
      if (!ends && (to - from).norm() < kStepCells * plane_.resolution) continue;
      sweep(from, to, std::exchange(step, {}), closed);
      from = to;
    }
  }

  /// All passes are over.
  template <typename Close>
  void finish(Close&& closed) {
    open_.for_each([&](Cell cell, const OpenPass& pass) {
      if (pass.left_m >= 0.0) closed(cell, pass);
    });
  }

 private:
  template <typename Close>
  void sweep(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const OpenPass& step,
             Close&& closed) {
    const double before_m = way_m_;
    way_m_ += static_cast<double>(step.way_m);
    for_each_swept_cell(plane_, from, to, reach_m_, [&](Cell cell) {
      OpenPass& pass = open_.at(cell);
      if (pass.left_m >= 0.0 && before_m - pass.left_m > kTravel.away_m) {
        closed(cell, pass);
        pass = {};
      }
      pass.left_m = way_m_;
      pass.way_m += step.way_m;
      pass.time_s += step.time_s;
    });
  }

  GridFrame plane_;  ///< without edges
  double reach_m_;
  double way_m_ = 0.0;  ///< of the drive, while it moved
  BlockGrid<OpenPass> open_;
};

}  // namespace

void Travel::add(const Trajectory& path, double footprint_radius_m) {
  const GridFrame& frame = cells_.frame();
  const double reach_m = std::max(footprint_radius_m, kHalfDiagonal * frame.resolution);
  const Cell corner = corner_of(frame);
  const auto closed = [&](Cell cell, const OpenPass& pass) {
    const Cell on_frame{cell.column - corner.column, cell.row - corner.row};
    if (frame.contains(on_frame)) close(pass, cells_[on_frame]);
  };
  Passage passage(frame.resolution, reach_m);
  for (const Run run : runs_of(path)) passage.drive(run, closed);
  passage.finish(closed);
}

}  // namespace loopstone
