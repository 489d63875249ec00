#pragma once

#include "loopstone/formats/topic_options.hpp"
#include "loopstone/sensor/robot_model.hpp"

namespace loopstone::python {

/// A robot, and what of its wheels somebody said rather than took for granted.
struct Robot {
  RobotModel model{};
  StatedWheels stated{};
};

}  // namespace loopstone::python
