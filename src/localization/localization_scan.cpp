#include "loopstone/localization/localization_scan.hpp"

#include <algorithm>
#include <cmath>

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
  const auto distance_at = [&](const Eigen::Vector2d& point) {
    return static_cast<double>(distances.value_or(distances.frame().cell_of(point), 1e3F));
  };
  int returns = 0;
  int on_wall = 0;
  int through = 0;
  int before = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const auto measured = static_cast<double>(scan.ranges_m[i]);
    const auto wall = static_cast<double>(expected[i]);
    if (!std::isfinite(measured)) {
      if (wall + kBeyondM < kSureRange * scan.range_max_m) ++through;
      continue;
    }
    ++returns;
    const Eigen::Vector2d end(measured * std::cos(scan.angles_rad[i]),
                              measured * std::sin(scan.angles_rad[i]));
    const double distance = distance_at(map_T_lidar * end);
    if (distance <= on_wall_m) ++on_wall;
    if (distance <= 2.0 * on_wall_m) continue;
    if (measured > wall + kBeyondM) ++through;
    if (measured < wall - kBeyondM) ++before;
  }
  const auto share = [](int part, std::size_t whole) {
    return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
  };
  return {share(on_wall, static_cast<std::size_t>(returns)), share(through, expected.size()),
          share(before, expected.size())};
}

}  // namespace loopstone
