// Which joints and frames are wheels.

#include "formats/wheel_names.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace loopstone {
namespace {

using testing::ElementsAre;

/// "left", "front right", "none".
std::string told(const std::string& name) {
  const auto spot = wheel_spot(name);
  if (!spot) return "none";
  const std::string row = spot->row == WheelRow::kFront  ? "front "
                          : spot->row == WheelRow::kRear ? "rear "
                                                         : "";
  return row + (spot->is_left ? "left" : "right");
}

TEST(WheelNames, Words) {
  EXPECT_THAT(words_of_name("base_to_LeftWheel"), ElementsAre("base", "to", "left", "wheel"));
  EXPECT_THAT(words_of_name("wheelFL"), ElementsAre("wheel", "fl"));
  EXPECT_THAT(words_of_name("drivewhl_l_joint"), ElementsAre("drive", "whl", "l", "joint"));
  EXPECT_THAT(words_of_name("/lwheel2/encoders"), ElementsAre("l", "wheel", "encoder"));
  EXPECT_THAT(words_of_name(""), ElementsAre());
  EXPECT_EQ(without_spot(words_of_name("/left_ticks")),
            without_spot(words_of_name("/right_ticks")));
}

TEST(WheelNames, SpellingsOfTheLeftWheel) {
  for (const char* const name :
       {"wheel_left_joint", "left_wheel", "base_to_left_wheel", "left_wheel_joint", "l_wheel_joint",
        "lwheel", "wheel_l", "LeftWheel", "leftWheelJoint", "drivewhl_l_joint", "joint_left_wheel",
        "robot1/wheel_left_joint", "base_l_drive_wheel_joint", "left_drive_wheel", "left_motor",
        "wheel_left_link", "whl_left"}) {
    EXPECT_EQ(told(name), "left") << name;
  }
  EXPECT_EQ(told("right_wheel_joint"), "right");
  EXPECT_EQ(told("rwheel"), "right");
}

TEST(WheelNames, FourWheels) {
  for (const char* const name :
       {"front_left_wheel_joint", "fl_wheel", "wheel_lf", "wheel_FL_joint", "left_front_wheel",
        "wheel_front_left_joint", "frontleft_wheel", "summit_front_left_wheel_joint"}) {
    EXPECT_EQ(told(name), "front left") << name;
  }
  for (const char* const name : {"rear_right_wheel", "rr_wheel", "wheel_RR_joint", "wheel_rb",
                                 "back_right_wheel_joint", "br_wheel"}) {
    EXPECT_EQ(told(name), "rear right") << name;
  }
  EXPECT_EQ(told("wheel_RL_joint"), "rear left");
  EXPECT_EQ(told("fr_wheel"), "front right");
}

TEST(WheelNames, NoWheelsThatDrive) {
  for (const char* const name :
       {"caster_left_wheel_joint", "fl_caster_rotation_joint", "front_left_steering_joint",
        "left_steering_wheel", "wheel_drop_left_joint", "left_arm_joint", "left_gripper_motor",
        "lidar_spin_joint", "laser_motor_left", "head_pan_joint", "left_elbow", "wheel",
        "imu_joint", "left", "left_right_wheel", "base_r_passive_wheel_x", "front_wheel",
        "left_brush_motor"}) {
    EXPECT_EQ(told(name), "none") << name;
  }
  EXPECT_TRUE(is_steering("front_left_steering_joint"));
  EXPECT_FALSE(is_steering("front_left_wheel_joint"));
  EXPECT_TRUE(is_command("/lwheel_vtarget"));
  EXPECT_TRUE(is_command("/cmd_wheels"));
  EXPECT_FALSE(is_command("/joint_states"));
}

}  // namespace
}  // namespace loopstone
