#include "registration/window_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/grid/grid_frame.hpp"

namespace loopstone {

namespace {

constexpr double kCellM = 0.2;
constexpr std::size_t kPoints = 48;
/// Farther surfaces say little that nearer ones do not.
constexpr double kReachM = 12.0;
constexpr std::size_t kRays = 90;
/// Shifts along a row that are scored at once.
constexpr int kLanes = 16;
/// Candidates are farther apart than this many steps of the lattice, in some direction.
constexpr int kApart = 2;
constexpr std::uint8_t kFree = 0;
constexpr std::uint8_t kUnseen = 100;
constexpr std::uint8_t kNear = 160;
constexpr std::uint8_t kHit = 200;

/// What the target scan says about the place, cell by cell.
struct CoarseGrid {
  GridFrame frame;
  std::vector<std::uint8_t> cells;

  [[nodiscard]] std::uint8_t& at(int column, int row) {
    return cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(frame.columns) +
                 static_cast<std::size_t>(column)];
  }
};

CoarseGrid draw(const ScanView& target, double margin_m) {
  Eigen::Vector2d low = target.lidar;
  Eigen::Vector2d high = target.lidar;
  for (const SurfacePoint& surface : target.surfaces) {
    const Eigen::Vector2d ray = surface.position.cast<double>() - target.lidar;
    const Eigen::Vector2d end = target.lidar + ray * std::min(1.0, kReachM / ray.norm());
    low = low.cwiseMin(end);
    high = high.cwiseMax(end);
  }
  CoarseGrid grid{frame_covering(low, high, kCellM, margin_m), {}};
  grid.cells.assign(grid.frame.cell_count() + kLanes, kUnseen);
  const std::size_t stride = std::max<std::size_t>(1, target.surfaces.size() / kRays);
  for (std::size_t i = 0; i < target.surfaces.size(); i += stride) {
    Eigen::Vector2d ray = target.surfaces[i].position.cast<double>() - target.lidar;
    const double length = ray.norm();
    const int steps = static_cast<int>(std::min(length, kReachM) / kCellM);
    if (steps < 1) continue;
    ray *= kCellM / length;
    const double inverse = 1.0 / kCellM;
    double x = (target.lidar.x() - grid.frame.origin.x()) * inverse;
    double y = (target.lidar.y() - grid.frame.origin.y()) * inverse;
    for (int k = 0; k < steps; ++k) {
      grid.at(static_cast<int>(x), static_cast<int>(y)) = kFree;
      x += ray.x() * inverse;
      y += ray.y() * inverse;
    }
  }
  for (const SurfacePoint& surface : target.surfaces) {
    const Eigen::Vector2d point = surface.position.cast<double>();
    if ((point - target.lidar).norm() > kReachM) continue;
    const Cell cell = grid.frame.cell_of(point);
    grid.at(cell.column, cell.row) = kHit;
    for (const Cell beside : {Cell{cell.column - 1, cell.row}, Cell{cell.column + 1, cell.row},
                              Cell{cell.column, cell.row - 1}, Cell{cell.column, cell.row + 1}}) {
      std::uint8_t& value = grid.at(beside.column, beside.row);
      value = std::max(value, kNear);
    }
  }
  return grid;
}

/// Some of the source's surfaces, evenly spread along them.
std::vector<Eigen::Vector2d> spread_points(const ScanView& source) {
  std::vector<Eigen::Vector2d> points;
  double length = 0.0;
  const auto step_to = [&](std::size_t i) {
    return std::min<double>((source.surfaces[i].position - source.surfaces[i - 1].position).norm(),
                            0.5);
  };
  for (std::size_t i = 1; i < source.surfaces.size(); ++i) length += step_to(i);
  const double spacing = length / static_cast<double>(kPoints);
  double since = spacing;
  for (std::size_t i = 0; i < source.surfaces.size(); ++i) {
    if (i > 0) since += step_to(i);
    if (since < spacing) continue;
    const Eigen::Vector2d point = source.surfaces[i].position.cast<double>();
    if ((point - source.lidar).norm() > kReachM) continue;
    points.push_back(point);
    since = std::min(since - spacing, spacing);
  }
  return points;
}

/// Sums of kLanes neighbouring shifts; 16 bits hold the sum of more points than are used.
using Lanes = std::array<std::int16_t, kLanes>;

/// Scores of all shifts at one heading, row by row.
struct HeadingScores {
  std::vector<Lanes> scores;
  std::int16_t best = 0;

  void find_best();
};

/// The shifts of the lattice: [-half, half] cells in row and column, in runs of lanes.
struct Shifts {
  int half = 0;
  int rows = 0;
  int runs = 0;  // of lanes, a row

  explicit Shifts(double half_xy_m)
      : half(static_cast<int>(std::ceil(half_xy_m / kCellM))),
        rows(2 * half + 1),
        runs((rows + kLanes - 1) / kLanes) {}
  /// Cells that a row of shifts reaches over.
  [[nodiscard]] int width() const { return runs * kLanes; }
};

/// Adds up the cells of all points for kLanes neighbouring shifts. Sums and cells are in arrays of
/// their own, which nothing else can point to, so the compiler keeps all lanes in registers (and
/// does so only when this isn't inlined).
[[gnu::noinline]] void sum_lanes(const std::uint8_t* cells, std::span<const std::int32_t> offsets,
                                 std::int16_t start, Lanes& result) {
  std::int16_t sums[kLanes];  // NOLINT(modernize-avoid-c-arrays)
  for (int k = 0; k < kLanes; ++k) sums[k] = start;
  for (const std::int32_t offset : offsets) {
    std::uint8_t values[kLanes];  // NOLINT(modernize-avoid-c-arrays)
    std::memcpy(values, cells + offset, kLanes);
    std::int16_t wide[kLanes];  // NOLINT(modernize-avoid-c-arrays)
    for (int k = 0; k < kLanes; ++k) wide[k] = values[k];
    for (int k = 0; k < kLanes; ++k) sums[k] = static_cast<std::int16_t>(sums[k] + wide[k]);
  }
  std::memcpy(result.data(), sums, sizeof(sums));
}

[[gnu::noinline]] std::int16_t greatest_of(const std::vector<Lanes>& scores) {
  std::int16_t greatest[kLanes] = {};  // NOLINT(modernize-avoid-c-arrays)
  for (const Lanes& lanes : scores) {
    std::int16_t values[kLanes];  // NOLINT(modernize-avoid-c-arrays)
    std::memcpy(values, lanes.data(), sizeof(values));
    for (int k = 0; k < kLanes; ++k)
      greatest[k] = values[k] > greatest[k] ? values[k] : greatest[k];
  }
  return *std::max_element(std::begin(greatest), std::end(greatest));
}

void HeadingScores::find_best() { best = greatest_of(scores); }

/// Scores every shift of the points, which are given in cells around the pivot, at one heading.
class HeadingScorer {
 public:
  HeadingScorer(const CoarseGrid& grid, const std::vector<Eigen::Vector2d>& points,
                const Eigen::Vector2d& centre, const Shifts& shifts)
      : grid_(grid), shifts_(shifts), offsets_(points.size()) {
    for (const auto& point : points) {
      xs_.push_back(static_cast<float>(point.x() / kCellM));
      ys_.push_back(static_cast<float>(point.y() / kCellM));
    }
    const Eigen::Vector2d cell = (centre - grid.frame.origin) / kCellM;
    x_ = static_cast<float>(cell.x()) - static_cast<float>(shifts.half);
    y_ = static_cast<float>(cell.y()) - static_cast<float>(shifts.half);
  }

  [[nodiscard]] HeadingScores operator()(double heading) {
    const auto cosine = static_cast<float>(std::cos(heading));
    const auto sine = static_cast<float>(std::sin(heading));
    const auto columns_inside = static_cast<float>(grid_.frame.columns - shifts_.width());
    const auto rows_inside = static_cast<float>(grid_.frame.rows - shifts_.rows);
    std::size_t inside = 0;
    for (std::size_t i = 0; i < xs_.size(); ++i) {
      const float x = cosine * xs_[i] - sine * ys_[i] + x_;
      const float y = sine * xs_[i] + cosine * ys_[i] + y_;
      if (!(x >= 0.0F && y >= 0.0F && x < columns_inside && y < rows_inside)) continue;
      offsets_[inside++] =
          static_cast<std::int32_t>(y) * grid_.frame.columns + static_cast<std::int32_t>(x);
    }
    // What falls off the grid is unseen, whatever the shift.
    const auto start = static_cast<std::int16_t>((xs_.size() - inside) * kUnseen);
    HeadingScores result;
    const int run_count = shifts_.rows * shifts_.runs;
    result.scores.reserve(static_cast<std::size_t>(run_count));
    for (int row = 0; row < shifts_.rows; ++row) {
      for (int run = 0; run < shifts_.runs; ++run) {
        const std::ptrdiff_t shift =
            static_cast<std::ptrdiff_t>(row) * grid_.frame.columns + run * kLanes;
        Lanes& lanes = result.scores.emplace_back();
        sum_lanes(grid_.cells.data() + shift, std::span(offsets_).first(inside), start, lanes);
        // Beyond the window: never the best.
        const int lanes_inside = std::min(kLanes, shifts_.rows - run * kLanes);
        std::fill(lanes.begin() + lanes_inside, lanes.end(), std::int16_t{0});
      }
    }
    result.find_best();
    return result;
  }

 private:
  const CoarseGrid& grid_;
  const Shifts& shifts_;
  std::vector<float> xs_{};
  std::vector<float> ys_{};
  std::vector<std::int32_t> offsets_;
  float x_ = 0.0F;
  float y_ = 0.0F;
};

/// A shift at a heading.
struct Place {
  int heading = 0;
  int row = 0;
  int column = 0;
};

Place best_place(const std::vector<HeadingScores>& headings, const Shifts& shifts) {
  const auto best = std::max_element(headings.begin(), headings.end(),
                                     [](const auto& a, const auto& b) { return a.best < b.best; });
  for (std::size_t run = 0; run < best->scores.size(); ++run) {
    const Lanes& lanes = best->scores[run];
    const auto found = std::find(lanes.begin(), lanes.end(), best->best);
    if (found == lanes.end()) continue;
    const int at = static_cast<int>(run);
    return {static_cast<int>(best - headings.begin()), at / shifts.runs,
            at % shifts.runs * kLanes + static_cast<int>(found - lanes.begin())};
  }
  return {};
}

/// Strikes out a place that was taken, and what lies next to it.
void strike_out(std::vector<HeadingScores>& headings, const Shifts& shifts, const Place& place) {
  const int last_heading = static_cast<int>(headings.size()) - 1;
  const int last_heading_near = std::min(last_heading, place.heading + kApart);
  for (int h = std::max(0, place.heading - kApart); h <= last_heading_near; ++h) {
    HeadingScores& near = headings[static_cast<std::size_t>(h)];
    const int last_row = std::min(shifts.rows - 1, place.row + kApart);
    for (int row = std::max(0, place.row - kApart); row <= last_row; ++row) {
      const int last_column = std::min(shifts.rows - 1, place.column + kApart);
      for (int column = std::max(0, place.column - kApart); column <= last_column; ++column) {
        const int run = row * shifts.runs + column / kLanes;
        const int lane = column % kLanes;
        near.scores[static_cast<std::size_t>(run)][static_cast<std::size_t>(lane)] = 0;
      }
    }
    near.find_best();
  }
}

}  // namespace

std::vector<Candidate> search_window(const ScanView& source, const ScanView& target,
                                     const Pose2& centre, double half_xy_m, double half_yaw_rad,
                                     int count) {
  const std::vector<Eigen::Vector2d> points = spread_points(source);
  if (points.empty() || target.surfaces.empty()) return {};
  const Shifts shifts(half_xy_m);
  const CoarseGrid grid = draw(target, (shifts.width() + 1) * kCellM);

  double squares = 0.0;
  for (const auto& point : points) squares += point.squaredNorm();
  const double arm_m = std::max(1.0, std::sqrt(squares / static_cast<double>(points.size())));
  const double yaw_step = kCellM / arm_m;
  const int half_headings = std::min(static_cast<int>(std::ceil(half_yaw_rad / yaw_step)),
                                     static_cast<int>(kPi / yaw_step));

  HeadingScorer score(grid, points, centre.translation(), shifts);
  std::vector<HeadingScores> headings;
  const int heading_count = 2 * half_headings + 1;
  headings.reserve(static_cast<std::size_t>(heading_count));
  for (int h = -half_headings; h <= half_headings; ++h)
    headings.push_back(score(centre.yaw + h * yaw_step));

  std::vector<Candidate> candidates;
  while (static_cast<int>(candidates.size()) < count) {
    const Place place = best_place(headings, shifts);
    const double mean =
        headings[static_cast<std::size_t>(place.heading)].best / static_cast<double>(points.size());
    if (mean <= kUnseen) break;
    candidates.push_back({{centre.x + (place.column - shifts.half) * kCellM,
                           centre.y + (place.row - shifts.half) * kCellM,
                           wrap_angle(centre.yaw + (place.heading - half_headings) * yaw_step)},
                          (mean - kUnseen) / (kHit - kUnseen)});
    strike_out(headings, shifts, place);
  }
  return candidates;
}

}  // namespace loopstone
