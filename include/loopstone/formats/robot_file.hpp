#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "loopstone/formats/topic_options.hpp"
#include "loopstone/sensor/robot_model.hpp"

namespace loopstone {

/// Reads a robot from TOML (robots/ucsd.toml shows every key). What the text does not name keeps
/// its default, the UCSD robot's; naming any lidar replaces the list of lidars.
/// \param path names the text in the problems
/// Throws OptionsError with all problems at once.
[[nodiscard]] RobotModel parse_robot(std::string_view toml, const std::string& path);

/// The same from a file. Throws DataError when it can't be read.
[[nodiscard]] RobotModel read_robot_file(const std::string& path);

/// What the text itself says of the wheels, without defaults. Throws OptionsError as parse_robot().
[[nodiscard]] StatedWheels stated_wheels(std::string_view toml, const std::string& path);

/// The same from a file. Throws DataError when it can't be read.
[[nodiscard]] StatedWheels read_stated_wheels(const std::string& path);

/// Keys of a robot file and their values in words: {"wheels.track_width_m", "0.4"},
/// {"lidars[1].x_m", "0.2"}.
using RobotValues = std::vector<std::pair<std::string, std::string>>;

/// The robot with other values of some keys; all else stays as it is to the bit. Every value is
/// checked, whoever gave it.
/// \param origin  names where the values come from in the problems
/// Throws OptionsError with all problems at once.
[[nodiscard]] RobotModel changed_robot(RobotModel robot, const RobotValues& changes,
                                       const std::string& origin);

/// What was stated of the wheels, and what somebody states of them now.
/// \param changes  of changed_robot(), which led to `wheels`
[[nodiscard]] StatedWheels changed_stated_wheels(StatedWheels stated, const WheelModel& wheels,
                                                 const RobotValues& changes);

/// The robot as TOML with help texts as comments. Read back it gives the same robot (angles of the
/// camera to 1e-12).
[[nodiscard]] std::string robot_to_toml(const RobotModel& robot);

}  // namespace loopstone
