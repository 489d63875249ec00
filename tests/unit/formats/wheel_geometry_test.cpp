// Track and radius by frames of wheels.

#include "formats/wheel_geometry.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>

namespace loopstone {
namespace {

Pose3 place(double x, double y, double z) {
  return Pose3::from_roll_pitch_yaw({x, y, z}, -1.57, 0.3, 0.0);
}

/// A robot whose base_link is 1 cm above its footprint.
FrameTree robot() {
  FrameTree frames;
  frames.add_fixed("base_footprint", "base_link",
                   Pose3::from_roll_pitch_yaw({0.0, 0.0, 0.010}, 0.0, 0.0, 0.0));
  frames.add("base_link", "wheel_left_link", Stamp{1}, place(0.0, 0.080, 0.023));
  frames.add("base_link", "wheel_right_link", Stamp{1}, place(0.0, -0.080, 0.023));
  frames.add_fixed("base_link", "caster_back_right_wheel", place(-0.1, 0.0, -0.004));
  frames.add_fixed("base_link", "base_scan", place(-0.03, 0.0, 0.1));
  return frames;
}

TEST(WheelGeometry, TrackAndRadius) {
  for (const char* const base : {"base_link", "base_footprint"}) {
    const WheelGeometry geometry = wheel_geometry(robot(), base);
    ASSERT_TRUE(geometry.track_width_m && geometry.radius_m) << base;
    EXPECT_NEAR(*geometry.track_width_m, 0.160, 1e-9);
    EXPECT_NEAR(*geometry.radius_m, 0.033, 1e-9);
  }
}

TEST(WheelGeometry, WheelsThatTurnStayWhereTheyAre) {
  FrameTree frames = robot();
  for (int i = 2; i < 50; ++i) {
    frames.add("base_link", "wheel_left_link", Stamp{i * std::int64_t{100'000'000}},
               Pose3::from_roll_pitch_yaw({0.0, 0.080, 0.023}, -1.57, 0.3 * i, 0.0));
  }
  EXPECT_NEAR(wheel_geometry(frames, "base_link").track_width_m.value_or(0.0), 0.160, 1e-9);
}

TEST(WheelGeometry, WithoutAFootprintNothingTellsTheRadius) {
  FrameTree frames;
  frames.add_fixed("base_link", "fl_wheel", place(0.2, 0.25, 0.1));
  frames.add_fixed("base_link", "fr_wheel", place(0.2, -0.25, 0.1));
  frames.add_fixed("base_link", "rl_wheel", place(-0.2, 0.27, 0.1));
  frames.add_fixed("base_link", "rr_wheel", place(-0.2, -0.27, 0.1));
  const WheelGeometry geometry = wheel_geometry(frames, "base_link");
  EXPECT_NEAR(geometry.track_width_m.value_or(0.0), 0.52, 1e-9);
  EXPECT_FALSE(geometry.radius_m);
}

TEST(WheelGeometry, ContradictionsTellNothing) {
  FrameTree crossed;
  crossed.add_fixed("base_footprint", "wheel_left_link", place(0.0, -0.1, 0.05));
  crossed.add_fixed("base_footprint", "wheel_right_link", place(0.0, 0.1, 0.05));
  EXPECT_FALSE(wheel_geometry(crossed, "base_footprint").track_width_m);
  FrameTree tilted;
  tilted.add_fixed("base_footprint", "wheel_left_link", place(0.0, 0.1, 0.05));
  tilted.add_fixed("base_footprint", "wheel_right_link", place(0.0, -0.1, 0.09));
  EXPECT_TRUE(wheel_geometry(tilted, "base_footprint").track_width_m);
  EXPECT_FALSE(wheel_geometry(tilted, "base_footprint").radius_m);
  FrameTree one;
  one.add_fixed("base_footprint", "wheel_left_link", place(0.0, 0.1, 0.05));
  EXPECT_FALSE(wheel_geometry(one, "base_footprint").track_width_m);
  EXPECT_FALSE(wheel_geometry(robot(), "").track_width_m);
}

TEST(WheelGeometry, OfSeveralRobotsTheOneThatIsAskedFor) {
  FrameTree frames;
  for (const auto& [name, y_m] : {std::pair{"a/", 0.1}, std::pair{"b/", 0.3}}) {
    const std::string robot = name;
    frames.add_fixed("map", robot + "base_link", {});
    frames.add_fixed(robot + "base_link", robot + "left_wheel", place(0.0, y_m, 0.0));
    frames.add_fixed(robot + "base_link", robot + "right_wheel", place(0.0, -y_m, 0.0));
  }
  EXPECT_NEAR(wheel_geometry(frames, "b/base_link").track_width_m.value_or(0.0), 0.6, 1e-9);
}

}  // namespace
}  // namespace loopstone
