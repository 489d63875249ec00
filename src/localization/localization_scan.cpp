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

SeenByLaser view_of_laser(const LaserScan& scan, const Pose2& robot_T_lidar,
                          const Tangent2& velocity, int count) {
  SeenByLaser view{.robot_T_lidar = robot_T_lidar, .range_max_m = scan.range_max_m};
  view.points_robot = scan_points(scan, robot_T_lidar, velocity);
  std::vector<std::size_t> beams;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    if (!std::isnan(scan.ranges_m[i])) beams.push_back(i);
  }
  for (const std::size_t beam : thinned(beams, static_cast<std::size_t>(count))) {
    view.angles_rad.push_back(scan.angle_rad(beam));
    view.ranges_m.push_back(scan.ranges_m[beam]);
  }
  return view;
}

LocalizationScan view_together(std::vector<SeenByLaser> lasers, int count) {
  const auto wanted = static_cast<std::size_t>(count);
  LocalizationScan view{.lasers = std::move(lasers)};
  const std::size_t of_each = (wanted + view.lasers.size() - 1) / view.lasers.size();
  for (SeenByLaser& laser : view.lasers) {
    view.points_robot.insert(view.points_robot.end(), laser.points_robot.begin(),
                             laser.points_robot.end());
    laser.angles_rad = thinned(laser.angles_rad, of_each);
    laser.ranges_m = thinned(laser.ranges_m, of_each);
  }
  for (const auto& point : thinned(view.points_robot, wanted))
    view.weighed.emplace_back(point.cast<float>());
  return view;
}

LocalizationScan view_for_localization(const LaserScan& scan, const Pose2& robot_T_lidar,
                                       const Tangent2& velocity, int count) {
  return view_together({view_of_laser(scan, robot_T_lidar, velocity, count)}, count);
}

namespace {

/// How many beams, of all lasers.
struct BeamCounts {
  int beams = 0;
  int returns = 0;
  int known = 0;
  int on_wall = 0;
  int through = 0;
  int before = 0;
  int silent = 0;
};

void count_beams(const SeenByLaser& laser, const LocalizationMap::Tables& tables,
                 const Pose2& map_T_robot, BeamCounts& counts) {
  const Grid<float>& distances = tables.search.field().distances();
  const double on_wall_m = kOnWallM + distances.frame().resolution;
  const Pose2 map_T_lidar = map_T_robot * laser.robot_T_lidar;
  std::vector<float> expected(laser.ranges_m.size());
  tables.caster.ranges(ScanRays{std::span(&map_T_lidar, 1), laser.angles_rad}, expected);
  counts.beams += static_cast<int>(expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const auto measured = static_cast<double>(laser.ranges_m[i]);
    const auto [nearest, farthest] = reach_around(expected, i);
    if (!std::isfinite(measured)) {
      if (farthest + kBeyondM < kSureRange * laser.range_max_m) ++counts.silent;
      continue;
    }
    ++counts.returns;
    const Eigen::Vector2d end =
        map_T_lidar * Eigen::Vector2d(measured * std::cos(laser.angles_rad[i]),
                                      measured * std::sin(laser.angles_rad[i]));
    const Cell cell = distances.frame().cell_of(end);
    const auto distance = static_cast<double>(distances.value_or(cell, 1e3F));
    const bool is_free = tables.occupancy.value_or(cell, std::int8_t{-1}) >= 0;
    if (is_free || distance <= 2.0 * on_wall_m) ++counts.known;
    if (distance <= on_wall_m) ++counts.on_wall;
    if (distance <= 2.0 * on_wall_m) continue;
    if (measured > farthest + kBeyondM) ++counts.through;
    if (is_free && measured < nearest - kBeyondM) ++counts.before;
  }
}

}  // namespace

BeamFit fit_beams(const LocalizationScan& scan, const LocalizationMap& map,
                  const Pose2& map_T_robot) {
  BeamCounts counts;
  for (const SeenByLaser& laser : scan.lasers)
    count_beams(laser, map.tables(), map_T_robot, counts);
  const auto share = [](int part, int whole) {
    return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
  };
  return {share(counts.on_wall, counts.known), share(counts.through, counts.beams),
          share(counts.before, counts.beams), share(counts.known, counts.returns),
          share(counts.silent, counts.beams)};
}

}  // namespace loopstone
