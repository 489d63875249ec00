#pragma once

#include <array>
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
//   LASER3, LASER4, LASER5   n r1..rn ipc_time host logger_time
//   ROBOTLASER1 type start fov resolution max_range accuracy remission_mode n r1..rn m rem1..remm
//               laser_x laser_y laser_theta robot_x robot_y robot_theta tv rv fwd side turn
//               ipc_time host logger_time; so to ROBOTLASER5
//   RAWLASER1   the same without everything between the remissions and ipc_time; so to RAWLASER5
//   TRUEPOS true_x true_y true_theta odom_x odom_y odom_theta ipc_time host logger_time

/// Lasers that the tags tell apart: front, rear, and three more.
inline constexpr int kCarmenLidars = 5;

/// In rows of kCarmenLidars: as a row reports it, laser by laser.
enum class CarmenTag {
  kFlaser,
  kRlaser,
  kLaser3,
  kLaser4,
  kLaser5,
  kRobotLaser1,
  kRobotLaser2,
  kRobotLaser3,
  kRobotLaser4,
  kRobotLaser5,
  kRawLaser1,
  kRawLaser2,
  kRawLaser3,
  kRawLaser4,
  kRawLaser5,
};

constexpr auto words_of(CarmenTag /*any*/) {
  using enum CarmenTag;
  return std::array{Word{kFlaser, "FLASER"},           Word{kRlaser, "RLASER"},
                    Word{kLaser3, "LASER3"},           Word{kLaser4, "LASER4"},
                    Word{kLaser5, "LASER5"},           Word{kRobotLaser1, "ROBOTLASER1"},
                    Word{kRobotLaser2, "ROBOTLASER2"}, Word{kRobotLaser3, "ROBOTLASER3"},
                    Word{kRobotLaser4, "ROBOTLASER4"}, Word{kRobotLaser5, "ROBOTLASER5"},
                    Word{kRawLaser1, "RAWLASER1"},     Word{kRawLaser2, "RAWLASER2"},
                    Word{kRawLaser3, "RAWLASER3"},     Word{kRawLaser4, "RAWLASER4"},
                    Word{kRawLaser5, "RAWLASER5"}};
}

/// 0 for the front laser, 1 for the rear one, below kCarmenLidars. FLASER, ROBOTLASER1 and
/// RAWLASER1 are reports of the same laser, and so on.
[[nodiscard]] constexpr int lidar_of(CarmenTag tag) {
  return static_cast<int>(tag) % kCarmenLidars;
}

/// The tag of true poses.
inline constexpr std::string_view kCarmenTruth = "TRUEPOS";

/// The times that close a line.
struct CarmenTimes {
  std::optional<Stamp> header{};  ///< ipc_time: when the sensor measured
  std::optional<Stamp> logger{};  ///< when it was written down, on the logger's own clock
  std::string header_problem{};   ///< why there is no `header`
  bool absent = false;            ///< the line ends before them
};

/// The beams as the line itself states them; only the newer tags do.
struct CarmenBeams {
  int laser_type = 0;  ///< 0 and 1 are SICK's LMS and PLS, 2 Hokuyo's URG
  double start_angle_rad = 0.0;
  double field_of_view_rad = 0.0;
  double resolution_rad = 0.0;
  double max_range_m = 0.0;
};

struct CarmenScan {
  CarmenTag tag = CarmenTag::kFlaser;
  CarmenTimes times{};
  std::optional<CarmenBeams> beams{};
  std::vector<float> raw_ranges_m{};  ///< codes for "no return" and "bad" still in it
  bool has_poses = false;
  Pose2 odom_T_lidar{};  ///< of corrected logs: the corrected pose
  Pose2 odom_T_robot{};
};

struct CarmenOdometry {
  CarmenTimes times{};
  Pose2 odom_T_robot;
};

/// A simulator's true pose.
struct CarmenTruth {
  CarmenTimes times{};
  Pose2 world_T_robot;
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

using CarmenLine =
    std::variant<CarmenOther, CarmenParam, CarmenOdometry, CarmenScan, CarmenTruth, CarmenBroken>;

[[nodiscard]] CarmenLine parse_carmen_line(std::string_view text);

}  // namespace loopstone
