// Recordings whose wheels are told as joints: what the commands make of them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "formats/recording_writer.hpp"
#include "formats/topic_writer.hpp"
#include "run_program.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr double kAngle = 60.0;  ///< that both wheels turn [rad]

msg::TransformStamped fixed(Stamp stamp, const std::string& child, double y, double z) {
  msg::TransformStamped transform{.header = {stamp, "base_footprint"}, .child_frame_id = child};
  transform.transform.translation = {.x = 0.0, .y = y, .z = z};
  return transform;
}

/// A robot that drives ahead for 20 s between two walls.
void write_recording(const std::string& path, bool wheel_frames) {
  TopicWriter writer(create_mcap(path));
  const Stamp start{1'700'000'000'000'000'000};
  msg::TFMessage frames{{fixed(start, "laser", 0.0, 0.3)}};
  if (wheel_frames) {
    frames.transforms.push_back(fixed(start, "wheel_left_link", 0.2, 0.05));
    frames.transforms.push_back(fixed(start, "wheel_right_link", -0.2, 0.05));
  }
  writer.send("/tf_static", start, frames, true);
  for (int i = 0; i <= 200; ++i) {
    const Stamp stamp = start + Duration::from_milliseconds(100 * i);
    msg::JointState joints{.header = {stamp, ""}};
    joints.name = {"wheel_left_joint", "arm_joint", "wheel_right_joint"};
    joints.position = {kAngle * i / 200.0, 0.5, kAngle * i / 200.0};
    writer.send("/joint_states", stamp, joints);
    msg::LaserScan scan{.header = {stamp, "laser"}};
    scan.angle_min = -1.0F;
    scan.angle_max = 1.0F;
    scan.angle_increment = 0.02F;
    scan.range_max = 20.0F;
    scan.ranges.assign(101, 2.0F);
    writer.send("/scan", stamp, scan);
  }
  writer.finish();
}

TEST(JointWheels, DeadReckoningByTheFramesOfTheWheels) {
  const TempDir folder;
  write_recording(folder / "run.mcap", true);
  const ProgramResult told =
      run_program({"odometry", folder / "run.mcap", "-o", folder / "a.tum", "--json"});
  ASSERT_EQ(told.exit_code, 0) << told.error;
  EXPECT_THAT(told.error, HasSubstr("radius 0.05 m (tf), track 0.4 m (tf)"));
  const auto json = nlohmann::json::parse(told.out);
  EXPECT_EQ(json.at("wheel_readings"), 201);
  EXPECT_NEAR(json.at("path_length_m").get<double>(), 0.05 * kAngle, 1e-3);

  const std::string robot = folder.write("robot.toml", "[wheels]\nradius_m = 0.1\n");
  const ProgramResult named = run_program({"odometry", folder / "run.mcap", "-o", folder / "b.tum",
                                           "--json", "--quiet", "--robot", robot});
  ASSERT_EQ(named.exit_code, 0) << named.error;
  EXPECT_NEAR(nlohmann::json::parse(named.out).at("path_length_m").get<double>(), 0.1 * kAngle,
              1e-3);
}

TEST(JointWheels, WhatIsNotKnownIsAskedFor) {
  const TempDir folder;
  write_recording(folder / "run.mcap", false);
  const ProgramResult info = run_program({"info", folder / "run.mcap"});
  ASSERT_EQ(info.exit_code, 0) << info.error;
  EXPECT_THAT(info.out, AllOf(HasSubstr("/joint_states: angles of wheels"),
                              HasSubstr("--robot FILE"), Not(HasSubstr("wheels   /joint"))));
  // A robot file that says nothing of the wheels does not make them those of the default robot.
  const std::string mounts = folder.write("mounts.toml", "[[lidars]]\nx_m = 0.1\n");
  const ProgramResult refused = run_program(
      {"odometry", folder / "run.mcap", "-o", folder / "a.tum", "--quiet", "--robot", mounts});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.error, HasSubstr("no odometry"));
  const std::string robot =
      folder.write("robot.toml", "[wheels]\nradius_m = 0.05\ntrack_width_m = 0.4\n");
  const ProgramResult done = run_program({"odometry", folder / "run.mcap", "-o", folder / "a.tum",
                                          "--quiet", "--json", "--robot", robot});
  ASSERT_EQ(done.exit_code, 0) << done.error;
  EXPECT_NEAR(nlohmann::json::parse(done.out).at("path_length_m").get<double>(), 0.05 * kAngle,
              1e-3);
}

TEST(JointWheels, WhatIsConvertedSaysWhatItsCountsMean) {
  const TempDir folder;
  write_recording(folder / "run.mcap", true);
  const ProgramResult converted =
      run_program({"convert", folder / "run.mcap", folder / "again.mcap"});
  ASSERT_EQ(converted.exit_code, 0) << converted.error;
  EXPECT_THAT(converted.error, HasSubstr("are of 5e-06 m each, with a track of 0.4 m"));
  const std::string robot =
      folder.write("robot.toml", "[wheels]\nmetres_per_count = 5e-06\ntrack_width_m = 0.4\n");
  const ProgramResult again =
      run_program({"odometry", folder / "again.mcap", "-o", folder / "a.tum", "--quiet", "--json",
                   "--robot", robot});
  ASSERT_EQ(again.exit_code, 0) << again.error;
  EXPECT_NEAR(nlohmann::json::parse(again.out).at("path_length_m").get<double>(), 0.05 * kAngle,
              1e-3);
}

}  // namespace
}  // namespace loopstone::test
