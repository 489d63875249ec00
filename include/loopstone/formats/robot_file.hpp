#pragma once

#include <string>
#include <string_view>

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

/// The robot as TOML with help texts as comments. Read back it gives the same robot (angles of the
/// camera to 1e-12).
[[nodiscard]] std::string robot_to_toml(const RobotModel& robot);

}  // namespace loopstone
