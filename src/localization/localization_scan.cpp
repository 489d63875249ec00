#include "loopstone/localization/localization_scan.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "localization/map_tables.hpp"
#include "loopstone/base/thinned.hpp"
#include "loopstone/sensor/scan_points.hpp"

namespace loopstone {

namespace {

/// A return is on a wall within this and a cell; beams differ from the map by more than kBeyondM
/// before that counts.
constexpr double kOnWallM = 0.07;
constexpr double kBeyondM = 0.4;
/// A beam without a return says that nothing is there only up to this share of the scanner's range:
/// dark and slanted surfaces send nothing back.
constexpr double kSureRange = 0.5;

/// The shortest and the longest of what a beam and its neighbours should measure [m].
std::pair<double, double> reach_around(std::span<const float> expected, std::size_t beam) {
  const std::size_t first = beam == 0 ? 0 : beam - 1;
  const std::size_t last = std::min(beam + 1, expected.size() - 1);
  const auto [least, most] = std::minmax({expected[first], expected[beam], expected[last]});
  return {static_cast<double>(least), static_cast<double>(most)};
}

}  // namespace

LocalizationScan view_for_localization(const LaserScan& scan, const Pose2& robot_T_lidar,
                                       const Tangent2& velocity, int count) {
  const auto wanted = static_cast<std::size_t>(count);
  LocalizationScan view{.robot_T_lidar = robot_T_lidar, .range_max_m = scan.range_max_m};
  view.points_robot = scan_points(scan, robot_T_lidar, velocity);
  for (const auto& point : thinned(view.points_robot, wanted))
    view.weighed.emplace_back(point.cast<float>());
  std::vector<std::size_t> beams;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    if (!std::isnan(scan.ranges_m[i])) beams.push_back(i);
  }
  for (const std::size_t beam : thinned(beams, wanted)) {
    view.angles_rad.push_back(scan.angle_rad(beam));
    view.ranges_m.push_back(scan.ranges_m[beam]);
  }
  return view;
}

BeamFit fit_beams(const LocalizationScan& scan, const LocalizationMap& map,
                  const Pose2& map_T_robot) {
  const auto& tables = map.tables();
  const Grid<float>& distances = tables.search.field().distances();
  const double on_wall_m = kOnWallM + distances.frame().resolution;
  const Pose2 map_T_lidar = map_T_robot * scan.robot_T_lidar;
  std::vector<float> expected(scan.ranges_m.size());
  tables.caster.ranges(ScanRays{std::span(&map_T_lidar, 1), scan.angles_rad}, expected);
  int returns = 0;
  int known = 0;
  int on_wall = 0;
  int through = 0;
  int before = 0;
  int silent = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const auto measured = static_cast<double>(scan.ranges_m[i]);
    const auto [nearest, farthest] = reach_around(expected, i);
    if (!std::isfinite(measured)) {
      if (farthest + kBeyondM < kSureRange * scan.range_max_m) ++silent;
      continue;
    }
    ++returns;
    const Eigen::Vector2d end =
        map_T_lidar * Eigen::Vector2d(measured * std::cos(scan.angles_rad[i]),
                                      measured * std::sin(scan.angles_rad[i]));
    const Cell cell = distances.frame().cell_of(end);
    const auto distance = static_cast<double>(distances.value_or(cell, 1e3F));
    const bool is_free = tables.occupancy.value_or(cell, std::int8_t{-1}) >= 0;
    if (is_free || distance <= 2.0 * on_wall_m) ++known;
    if (distance <= on_wall_m) ++on_wall;
    if (distance <= 2.0 * on_wall_m) continue;
    if (measured > farthest + kBeyondM) ++through;
    if (is_free && measured < nearest - kBeyondM) ++before;
  }
  const auto share = [](int part, auto whole) {
    return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
  };
  return {share(on_wall, known), share(through, expected.size()), share(before, expected.size()),
          share(known, returns), share(silent, expected.size())};
}

}  // namespace loopstone
