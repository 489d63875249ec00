#include "registration/score_volume.hpp"

#include <cmath>
#include <compare>
#include <initializer_list>
#include <map>
#include <set>
#include <vector>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/rigid_motion.hpp"
#include "registration/search_lattice.hpp"
#include "registration/shift_sums.hpp"

namespace loopstone {

namespace {

constexpr int kLanes = MaxPyramid::kLanes;
/// Poses less likely than exp(-kDepth) of the best add nothing that matters.
constexpr double kDepth = 12.0;
/// No volume that is of use has more poses.
constexpr std::int64_t kMaxPoses = 2'000'000;

/// kLanes poses side by side; column counts in strips.
struct Strip {
  int heading = 0;
  int row = 0;
  int column = 0;
  friend auto operator<=>(const Strip&, const Strip&) = default;
};

/// Sums for strips around the peak, at the steps of the search's lattice.
class Strips {
 public:
  Strips(std::span<const Eigen::Vector2d> source, const MaxPyramid& target, const Pose2& peak)
      : source_(source),
        frame_(target.frame()),
        lattice_(make_search_lattice(source, frame_, {peak, 0.0, 0.0})),
        arms_(arms_of(source, lattice_)),
        peak_yaw_(peak.yaw),
        rows_(target.level(0), 1),
        scan_(target.level(0), rows_) {}

  [[nodiscard]] LaneSums sums(const Strip& strip) {
    scan_.lay(cells(strip.heading), strip.column * kLanes, strip.row);
    scan_.choose_lanes(0);
    LaneSums sums{};
    for (std::size_t begin = 0; begin < source_.size(); begin += ScanOnLevel::kMaxCells)
      scan_.add(0, begin, std::min(begin + ScanOnLevel::kMaxCells, source_.size()), sums);
    return sums;
  }

  [[nodiscard]] double heading_step() const { return lattice_.heading_step_rad; }
  [[nodiscard]] const Eigen::Vector2d& pivot_in_target() const { return lattice_.pivot_in_target; }
  [[nodiscard]] const Eigen::Vector2d& pivot() const { return lattice_.pivot; }
  [[nodiscard]] Pose2 pose_at(int heading, int column, int row) {
    lattice_.headings = {peak_yaw_ + heading * heading_step()};
    return lattice_.pose_at(0, column, row);
  }

 private:
  const CellList& cells(int heading) {
    const auto [at, is_new] = cells_.try_emplace(heading);
    if (is_new) {
      lattice_.headings = {peak_yaw_ + heading * heading_step()};
      at->second = cells_at(arms_, frame_, lattice_, 0);
    }
    return at->second;
  }

  std::span<const Eigen::Vector2d> source_;
  GridFrame frame_;
  SearchLattice lattice_;
  std::vector<Eigen::Vector2d> arms_;
  double peak_yaw_;
  RowTable rows_;
  ScanOnLevel scan_;
  std::map<int, CellList> cells_{};
};

/// Mean and covariance of weighted motions.
struct Moments {
  double weight = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();

  void add(double likelihood, const Eigen::Vector3d& motion) {
    weight += likelihood;
    first += likelihood * motion;
    second.noalias() += likelihood * motion * motion.transpose();
  }
};

}  // namespace

ScoreVolume score_volume(std::span<const Eigen::Vector2d> source, const MaxPyramid& target,
                         const SearchWindow& window, const Pose2& peak, double evidence) {
  Strips strips(source, target, peak);
  const double resolution = target.frame().resolution;
  // The peak, counted from the window's centre; a pose outside of the window by more than rounding
  // isn't looked at.
  const Eigen::Vector2d offset = strips.pivot_in_target() - window.centre * strips.pivot();
  const double turned = wrap_angle(peak.yaw - window.centre.yaw);
  const auto is_inside = [&](int heading, int column, int row) {
    return std::abs(offset.x() + column * resolution) < window.half_xy_m + resolution &&
           std::abs(offset.y() + row * resolution) < window.half_xy_m + resolution &&
           std::abs(turned + heading * strips.heading_step()) <
               std::min(window.half_yaw_rad + strips.heading_step(), kPi);
  };
  const bool whole_circle = window.half_yaw_rad >= kPi - strips.heading_step();

  ScoreVolume volume;
  volume.step = {resolution, resolution, strips.heading_step()};
  const double per_unit = evidence / (kSurface - kUnknown);
  const std::int32_t best = strips.sums({})[0];
  Moments moments;
  std::set<Strip> known{Strip{}};
  std::vector<Strip> open{Strip{}};
  const auto look_at = [&](const Strip& strip) {
    if (known.insert(strip).second) open.push_back(strip);
  };
  while (!open.empty() && volume.evaluations < kMaxPoses) {
    const Strip strip = open.back();
    open.pop_back();
    const LaneSums sums = strips.sums(strip);
    volume.evaluations += kLanes;
    bool counts = false;
    for (int lane = 0; lane < kLanes; ++lane) {
      const int column = strip.column * kLanes + lane;
      const double log_likelihood = per_unit * (sums[static_cast<std::size_t>(lane)] - best);
      if (log_likelihood < -kDepth) continue;
      if (!is_inside(strip.heading, column, strip.row)) {
        const bool turned_round =
            whole_circle && std::abs(turned + strip.heading * strips.heading_step()) >= kPi;
        volume.leaves_window = volume.leaves_window || (!turned_round && log_likelihood > -2.0);
        continue;
      }
      counts = true;
      const double likelihood = std::exp(std::min(log_likelihood, 0.0));
      const Pose2 pose = strips.pose_at(strip.heading, column, strip.row);
      moments.add(likelihood, RigidMotion<2>::difference(pose, peak));
    }
    if (!counts) continue;
    for (const int side : {-1, 1}) {
      look_at({strip.heading + side, strip.row, strip.column});
      look_at({strip.heading, strip.row + side, strip.column});
      look_at({strip.heading, strip.row, strip.column + side});
    }
  }
  if (moments.weight > 0.0) {
    volume.mean = moments.first / moments.weight;
    volume.covariance = moments.second / moments.weight - volume.mean * volume.mean.transpose();
  }
  return volume;
}

}  // namespace loopstone
