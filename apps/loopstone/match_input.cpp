#include "match_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>

#include "interrupt.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/decimal_stamp.hpp"
#include "loopstone/formats/log_format.hpp"
#include "loopstone/formats/point_cloud_file.hpp"
#include "loopstone/registration/likelihood_field.hpp"
#include "loopstone/sensor/scan_points.hpp"

namespace loopstone::app {

namespace {

namespace fs = std::filesystem;

bool ends_with_any(const std::string& name, std::initializer_list<const char*> endings) {
  for (const char* ending : endings) {
    if (name.ends_with(ending)) return true;
  }
  return false;
}

/// Throws DataError for a map that is all free or all wall: nothing can be aligned with it.
void require_walls(const CellStates& map, const std::string& name) {
  constexpr double kMostWallShare = 0.9;
  const auto& cells = map.cells();
  const auto walls = std::count_if(cells.begin(), cells.end(), [](std::int8_t percent) {
    return percent >= MapFieldOptions{}.occupied_percent;
  });
  if (walls == 0) {
    throw DataError({name},
                    "shows no wall, so nothing can be aligned with it; check its thresholds");
  }
  const double share = static_cast<double>(walls) / static_cast<double>(cells.size());
  if (share > kMostWallShare) {
    throw DataError({name}, fmt::format("is wall to {:.0f} %, so nothing can be aligned with it; "
                                        "check its thresholds and 'negate'",
                                        100.0 * share));
  }
}

}  // namespace

std::vector<Eigen::Vector2d> MatchInput::points2() const {
  if (scan) return scan_points(scan->scan, scan->robot_T_lidar, scan->velocity);
  if (map) return wall_points(*map);
  std::vector<Eigen::Vector2d> points;
  for (const Eigen::Vector3d& point : cloud->points) {
    if (is_usable_point(point)) points.emplace_back(point.head<2>());
  }
  return points;
}

std::vector<Eigen::Vector3d> MatchInput::points3() const {
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3d& point : cloud->points) {
    if (is_usable_point(point)) points.push_back(point);
  }
  return points;
}

RobotScan MatchInput::robot_scan() const {
  return {scan->scan, scan->robot_T_lidar, scan->velocity};
}

std::string MatchInput::kind() const { return scan ? "scan" : cloud ? "cloud" : "map"; }

std::string MatchInput::description() const {
  if (scan) {
    return fmt::format("scan {} at {} s, {} beams", scan->index,
                       format_decimal_stamp(scan->scan.stamp), scan->scan.ranges_m.size());
  }
  if (map) {
    const GridFrame& frame = map->frame();
    return fmt::format("map of {:.1f} m x {:.1f} m, cells of {:g} m",
                       frame.columns * frame.resolution, frame.rows * frame.resolution,
                       frame.resolution);
  }
  return fmt::format("cloud of {} points, {}", cloud->points.size(),
                     cloud->planar ? "in the plane" : "in space");
}

MatchInput read_match_input(const std::string& name, const AppContext& context) {
  MatchInput input{.name = name};
  if (ends_with_any(name, {".yaml", ".yml"})) {
    input.map = read_ros_map(name, context.memory(), MapField::kBytesPerCell);
    require_walls(*input.map, name);
    return input;
  }
  if (const auto scan = parse_scan_name(name)) {
    input.scan = read_log_scan(*scan, context.robot(), context.robot_given(),
                               {.memory = context.memory(),
                                .stop = interrupted,
                                .topics = {.wheels = context.stated_wheels()}});
    return input;
  }
  std::error_code ignored;
  if (fs::is_directory(name, ignored) || (fs::exists(name, ignored) && has_log_ending(name))) {
    throw UsageError("'" + name + "' is a whole log; name one scan of it: " + name + "#120 or " +
                     name + "@+12.5 (seconds after the first scan)");
  }
  const std::size_t mark = name.find_last_of("#@");
  if (mark != std::string::npos && !is_point_cloud_name(name) && !fs::exists(name, ignored)) {
    throw DataError({name.substr(0, mark)}, "there is no such file or folder");
  }
  input.cloud = read_point_cloud(name, context.memory());
  return input;
}

}  // namespace loopstone::app
