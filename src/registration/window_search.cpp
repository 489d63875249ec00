#include "registration/window_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/grid/grid_frame.hpp"

namespace loopstone {

namespace {

constexpr double kCellM = 0.2;
constexpr std::size_t kPoints = 56;
/// Farther surfaces say little that nearer ones do not.
constexpr double kReachM = 12.0;
constexpr std::size_t kRays = 180;
/// Shifts along a row that are scored at once.
constexpr int kLanes = 16;
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

/// Scores of all shifts at one heading, row by row.
struct HeadingScores {
  std::vector<std::uint16_t> scores;
  std::size_t best = 0;

  void find_best() {
    best = static_cast<std::size_t>(
        std::max_element(scores.begin(), scores.end()) - scores.begin());
  }
};

}  // namespace

std::vector<Candidate> search_window(const ScanView& source, const ScanView& target,
                                     const Pose2& centre, double half_xy_m, double half_yaw_rad,
                                     int count) {
  const std::vector<Eigen::Vector2d> points = spread_points(source);
  if (points.empty() || target.surfaces.empty()) return {};
  const CoarseGrid grid = draw(target, half_xy_m + kLanes * kCellM);
  const GridFrame& frame = grid.frame;

  const int half = static_cast<int>(std::ceil(half_xy_m / kCellM));
  const int rows = 2 * half + 1;
  const int columns = (rows + kLanes - 1) / kLanes * kLanes;
  double squares = 0.0;
  for (const auto& point : points) squares += point.squaredNorm();
  const double arm = std::max(1.0, std::sqrt(squares / static_cast<double>(points.size())));
  const double yaw_step = kCellM / arm;
  const int half_headings =
      std::min(static_cast<int>(std::ceil(half_yaw_rad / yaw_step)), static_cast<int>(kPi / yaw_step));

  std::vector<HeadingScores> headings(static_cast<std::size_t>(2 * half_headings + 1));
  std::vector<const std::uint8_t*> cells(points.size());
  for (int h = -half_headings; h <= half_headings; ++h) {
    const Pose2 pose{centre.x, centre.y, centre.yaw + h * yaw_step};
    const Eigen::Matrix2d rotation = pose.rotation();
    std::size_t inside = 0;
    for (const auto& point : points) {
      const Cell cell = frame.cell_of(rotation * point + pose.translation());
      const int column = cell.column - half;
      const int row = cell.row - half;
      if (column < 0 || row < 0 || column + columns > frame.columns ||
          row + rows > frame.rows)
        continue;
      cells[inside++] = &grid.cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(frame.columns) + static_cast<std::size_t>(column)];
    }
    HeadingScores& result = headings[static_cast<std::size_t>(h + half_headings)];
    result.scores.resize(static_cast<std::size_t>(rows * columns));
    const auto outside = static_cast<std::uint16_t>((points.size() - inside) * kUnseen);
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; column += kLanes) {
        std::array<std::uint16_t, kLanes> sum;
        sum.fill(outside);
        const std::ptrdiff_t offset = static_cast<std::ptrdiff_t>(row) * frame.columns + column;
        for (std::size_t i = 0; i < inside; ++i) {
          const std::uint8_t* values = cells[i] + offset;
          for (int k = 0; k < kLanes; ++k)
            sum[static_cast<std::size_t>(k)] = static_cast<std::uint16_t>(sum[static_cast<std::size_t>(k)] + values[k]);
        }
        // Lanes beyond the window stay 0.
        std::copy_n(sum.begin(), std::min(kLanes, rows - column),
                    result.scores.begin() + row * columns + column);
      }
    }
    result.find_best();
  }

  std::vector<Candidate> candidates;
  while (static_cast<int>(candidates.size()) < count) {
    const auto best = std::max_element(headings.begin(), headings.end(), [](const auto& a, const auto& b) {
      return a.scores[a.best] < b.scores[b.best];
    });
    const std::uint16_t value = best->scores[best->best];
    if (value == 0) break;
    const int h = static_cast<int>(best - headings.begin());
    const int row = static_cast<int>(best->best) / columns;
    const int column = static_cast<int>(best->best) % columns;
    candidates.push_back(
        {{centre.x + (column - half) * kCellM, centre.y + (row - half) * kCellM,
          wrap_angle(centre.yaw + (h - half_headings) * yaw_step)},
         (static_cast<double>(value) / static_cast<double>(points.size()) - kUnseen) / (kHit - kUnseen)});
    for (int k = std::max(0, h - 2); k <= std::min<int>(static_cast<int>(headings.size()) - 1, h + 2); ++k) {
      HeadingScores& near = headings[static_cast<std::size_t>(k)];
      for (int r = std::max(0, row - 2); r <= std::min(rows - 1, row + 2); ++r)
        for (int c = std::max(0, column - 2); c <= std::min(columns - 1, column + 2); ++c)
          near.scores[static_cast<std::size_t>(r * columns + c)] = 0;
      near.find_best();
    }
  }
  return candidates;
}

}  // namespace loopstone
