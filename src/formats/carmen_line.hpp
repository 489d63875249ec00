#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/base/words.hpp"
#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

// One line of a CARMEN log, as it stands there (CARMEN src/logger/writelog.c):
//   PARAM name value ipc_time host logger_time
//   ODOM x y theta tv rv accel ipc_time host logger_time
//   FLASER n r1..rn x y theta odom_x odom_y odom_theta ipc_time host logger_time
//   RLASER      the same of the rear laser
//   ROBOTLASER1 type start fov resolution max_range accuracy remission_mode n r1..rn m rem1..remm
//               laser_x laser_y laser_theta robot_x robot_y robot_theta tv rv fwd side turn
//               ipc_time host logger_time
//   RAWLASER1   the same without everything between the remissions and ipc_time

enum class CarmenTag { kFlaser, kRlaser, kRobotLaser, kRawLaser };

constexpr auto words_of(CarmenTag /*any*/) {
  using enum CarmenTag;
  return std::array{Word{kFlaser, "FLASER"}, Word{kRlaser, "RLASER"},
                    Word{kRobotLaser, "ROBOTLASER1"}, Word{kRawLaser, "RAWLASER1"}};
}

/// 0 for the front laser, 1 for the rear one; ROBOTLASER1 and RAWLASER1 are other reports of the
/// front laser.
[[nodiscard]] int lidar_of(CarmenTag tag);

/// The beams as the line itself states them; only the newer tags do.
struct CarmenBeams {
  double start_angle_rad = 0.0;
  double field_of_view_rad = 0.0;
  double resolution_rad = 0.0;
  double max_range_m = 0.0;
};

struct CarmenScan {
  CarmenTag tag = CarmenTag::kFlaser;
  Stamp stamp;
  std::optional<CarmenBeams> beams{};
  std::vector<float> raw_ranges_m{};  ///< codes for "no return" and "bad" still in it
  bool has_poses = false;
  Pose2 odom_T_lidar{};  ///< of corrected logs: the corrected pose
  Pose2 odom_T_robot{};
  std::optional<Stamp> logger_stamp{};  ///< when it was written down, on the logger's own clock
};

struct CarmenOdometry {
  Stamp stamp;
  Pose2 odom_T_robot;
  std::optional<Stamp> logger_stamp{};
};

struct CarmenParam {
  std::string name;
  std::string value;
};

/// A line with nothing for us: a comment, an empty line, or a tag that is not read.
struct CarmenOther {
  std::string_view tag{};  ///< empty for comments and empty lines; points into the line
};

/// A line that is not what its tag promises.
struct CarmenBroken {
  std::string reason;
  bool is_scan = false;
  bool has_tag = true;  ///< it begins as a line of a CARMEN log does
};

using CarmenLine = std::variant<CarmenOther, CarmenParam, CarmenOdometry, CarmenScan, CarmenBroken>;

[[nodiscard]] CarmenLine parse_carmen_line(std::string_view text);

}  // namespace loopstone
