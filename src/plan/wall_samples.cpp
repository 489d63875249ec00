#include "loopstone/plan/wall_samples.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "loopstone/sensor/scan_points.hpp"
#include "plan/plan_numbers.hpp"

namespace loopstone {

namespace {

bool is_occupied(const Grid<std::int8_t>& cells, Cell cell) {
  return cells.value_or(cell, -1) >= kPlan.occupied_percent;
}

bool is_free(const Grid<std::int8_t>& cells, Cell cell) {
  const std::int8_t value = cells.value_or(cell, -1);
  return value >= 0 && value < kPlan.occupied_percent;
}

/// Whether the map has a wall within a cell of it.
bool near_wall(const Grid<std::int8_t>& cells, const Eigen::Vector2d& point) {
  const Cell at = cells.frame().cell_of(point);
  for (int row = -1; row <= 1; ++row) {
    for (int column = -1; column <= 1; ++column)
      if (is_occupied(cells, {at.column + column, at.row + row})) return true;
  }
  return false;
}

/// Of the robot during its sweep, its own frame, as the front end had it.
Tangent2 velocity_in(const MappedScan& mapped) {
  const double sweep_s = sweep_seconds(mapped.scan);
  if (sweep_s == 0.0) return Tangent2::Zero();
  return log(mapped.local_T_robot.inverse() * mapped.local_T_robot_end) / std::abs(sweep_s);
}

}  // namespace

WallSamples samples_of_scans(std::span<const MappedScan* const> scans,
                             const Trajectory& map_T_robot, const Grid<std::int8_t>& cells,
                             Threads threads, const Pose2& robot_T_told) {
  WallSamples found{
      .origin = cells.frame().origin, .common_sigma_m = kPlan.scans_common_m, .from_scans = true};
  const SurfaceOptions options{.support_m = kPlan.support_m,
                               .spacing_m = kPlan.spacing_m,
                               .range_max_m = kPlan.range_max_m,
                               .points_max = kPlan.points_max};
  std::vector<std::vector<WallSample>> of_scan(scans.size());
  parallel_for(scans.size(), threads, [&](std::size_t i) {
    const MappedScan& mapped = *scans[i];
    const auto robot = map_T_robot.nearest(mapped.scan.stamp, Duration::from_seconds(1e-6));
    if (!robot || !robot->vector().allFinite()) return;
    const Pose2 map_T_told = *robot * robot_T_told;
    BeamTable beams;
    const Eigen::Matrix2d rotation = map_T_told.rotation();
    for (const SurfacePoint& surface :
         surface_points(mapped.scan, mapped.robot_T_lidar, velocity_in(mapped), options, beams)) {
      if (!(surface.weight >= 1.0F)) continue;
      const Eigen::Vector2d point = map_T_told * Eigen::Vector2d(surface.position.cast<double>());
      if (!near_wall(cells, point)) continue;
      of_scan[i].push_back({.point = (point - found.origin).cast<float>(),
                            .normal = (rotation * surface.normal.cast<double>()).cast<float>(),
                            .scan = static_cast<std::int32_t>(i)});
    }
  });
  std::size_t count = 0;
  for (const auto& samples : of_scan) count += samples.size();
  found.samples.reserve(count);
  for (const auto& samples : of_scan)
    found.samples.insert(found.samples.end(), samples.begin(), samples.end());
  return found;
}

WallSamples samples_of_cells(const Grid<std::int8_t>& cells) {
  const GridFrame& frame = cells.frame();
  WallSamples found{.origin = frame.origin, .common_sigma_m = frame.resolution / std::sqrt(12.0)};
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      if (!is_occupied(cells, {column, row})) continue;
      // The side it is seen from: where, within two cells, there is more free than not. A cell
      // with free space on both sides is a thin wall, and has a sample for each.
      constexpr std::array<Cell, 4> kSides{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
      constexpr int kReach = 2;
      for (const Cell side : kSides) {
        if (!is_free(cells, {column + side.column, row + side.row})) continue;
        Eigen::Vector2d towards = Eigen::Vector2d::Zero();
        for (int r = -kReach; r <= kReach; ++r) {
          for (int c = -kReach; c <= kReach; ++c) {
            const Eigen::Vector2d offset(c, r);
            if (offset.dot(Eigen::Vector2d(side.column, side.row)) < -0.5) continue;
            if (is_free(cells, {column + c, row + r})) towards += offset;
          }
        }
        if (towards.norm() < 1e-9) continue;
        found.samples.push_back(
            {.point = (frame.centre_of({column, row}) - frame.origin).cast<float>(),
             .normal = towards.normalized().cast<float>()});
      }
    }
  }
  return found;
}

void add_walls(std::span<const Polygon2> walls, const Grid<std::int8_t>& cells,
               WallSamples& samples) {
  const double cell_m = cells.frame().resolution;
  for (const Polygon2& wall : walls) {
    for (std::size_t i = 0; i < wall.corners.size(); ++i) {
      const Eigen::Vector2d& from = wall.corners[i];
      const Eigen::Vector2d along = wall.corners[(i + 1) % wall.corners.size()] - from;
      if (!(along.norm() > 0.0)) continue;
      Eigen::Vector2d out = Eigen::Vector2d(along.y(), -along.x()).normalized();
      constexpr double kBesideM = 1e-4;
      if (contains(wall, from + 0.5 * along + kBesideM * out)) out = -out;
      const int steps = static_cast<int>(std::ceil(along.norm() / kPlan.spacing_m));
      for (int step = 0; step <= steps; ++step) {
        const Eigen::Vector2d point = from + along * (static_cast<double>(step) / steps);
        // Beyond the cells that the side runs through, which are the wall's.
        if (!is_free(cells, cells.frame().cell_of(point + 2.0 * cell_m * out))) continue;
        for (int scan = 0; scan < kPlan.least_scans; ++scan) {
          samples.samples.push_back({.point = (point - samples.origin).cast<float>(),
                                     .normal = out.cast<float>(),
                                     .scan = -1 - scan});
        }
      }
    }
  }
}

}  // namespace loopstone
