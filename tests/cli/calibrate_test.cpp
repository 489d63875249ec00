#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "loopstone/formats/robot_file.hpp"
#include "run_program.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

using testing::HasSubstr;

/// Two minutes in an office with a laser whose mount no file tells.
class CalibrateCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempDir;
    log_ = *folder_ / "sim";
    const ProgramResult result =
        run_program({"simulate", "office", "-o", log_, "--seed", "1", "--duration", "120",
                     "--beams", "181", "--scan-rate", "5", "--realism", "mount", "--quiet"});
    ASSERT_EQ(result.exit_code, 0) << result.error;
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static inline TempDir* folder_ = nullptr;
  static inline std::string log_;
};

TEST_F(CalibrateCommand, TellsAndWritesARobotThatIsRightAfterwards) {
  const std::string robot = *folder_ / "robot.toml";
  const ProgramResult result = run_program({"calibrate", log_, "-o", robot, "--json", "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("lidar").at("is_off"), true);
  const double yaw_rad = json.at("lidar").at("yaw_rad").at("value");
  EXPECT_EQ(json.at("lidar").at("yaw_rad").at("given"), 0.0);
  EXPECT_EQ(json.at("lidar").at("yaw_rad").at("observable"), true);
  const RobotModel written = read_robot_file(robot);
  EXPECT_NEAR(written.lidars.at(0).robot_T_lidar.yaw, yaw_rad, 1e-9);
  // The simulated wheels go 2 % too far.
  EXPECT_NEAR(written.wheels.metres_per_count, 0.0022 / 1.02, 0.00001);

  const ProgramResult again = run_program({"calibrate", log_, "--robot", robot, "--json"});
  ASSERT_EQ(again.exit_code, 0) << again.error;
  const auto now = nlohmann::json::parse(again.out);
  EXPECT_EQ(now.at("lidar").at("is_off"), false);
  EXPECT_NEAR(now.at("odometry").at("translation_scale").at("value").get<double>(), 1.0, 0.001);
}

TEST_F(CalibrateCommand, TableSaysWhatIsGiven) {
  const ProgramResult result = run_program({"calibrate", log_, "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.out, HasSubstr("given 140.0"));
  EXPECT_THAT(result.out, HasSubstr("laser's mount is wrong"));
  EXPECT_THAT(result.out, HasSubstr("track"));
}

/// --quiet is about stderr: the result is what was asked for, as of every command.
TEST_F(CalibrateCommand, QuietSaysNothingBesideTheResult) {
  const ProgramResult calibrated = run_program({"calibrate", log_, "--quiet"});
  EXPECT_EQ(calibrated.error, "");
  EXPECT_EQ(calibrated.out, run_program({"calibrate", log_}).out);
}

TEST_F(CalibrateCommand, TooLittleIsAnErrorThatLeavesNothing) {
  const std::string robot = *folder_ / "short.toml";
  const ProgramResult result =
      run_program({"calibrate", log_, "-o", robot, "--duration", "8", "--quiet"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.error, HasSubstr("too little to calibrate by"));
  EXPECT_FALSE(std::filesystem::exists(robot));
}

TEST_F(CalibrateCommand, MapSaysWhatItCorrected) {
  const std::string out = *folder_ / "out";
  const ProgramResult map = run_program({"map", log_, "-o", out, "--json"});
  ASSERT_EQ(map.exit_code, 0) << map.error;
  EXPECT_THAT(map.error, HasSubstr("of where its mount says"));
  const auto summary = nlohmann::json::parse(map.out);
  EXPECT_EQ(summary.at("calibration").at("mount_corrected"), true);
  const ProgramResult plain =
      run_program({"map", log_, "-o", *folder_ / "plain", "--no-calibration", "--json", "--quiet"});
  ASSERT_EQ(plain.exit_code, 0) << plain.error;
  EXPECT_EQ(nlohmann::json::parse(plain.out).at("calibration").at("motions"), 0);
  const ProgramResult textbook = run_program(
      {"map", log_, "-o", *folder_ / "textbook", "--pipeline", "scan_to_scan", "--no-calibration"});
  EXPECT_EQ(textbook.exit_code, 2);
}

TEST_F(CalibrateCommand, BeamsThatAreOffAreMappedAnew) {
  const std::string log = *folder_ / "unkind";
  const ProgramResult simulated =
      run_program({"simulate", "office", "-o", log, "--seed", "2", "--duration", "120", "--beams",
                   "181", "--scan-rate", "5", "--realism", "upside_down,sweep", "--quiet"});
  ASSERT_EQ(simulated.exit_code, 0) << simulated.error;
  const std::string robot = *folder_ / "unkind.toml";
  const ProgramResult found = run_program({"calibrate", log, "-o", robot, "--json", "--quiet"});
  ASSERT_EQ(found.exit_code, 0) << found.error;
  EXPECT_EQ(nlohmann::json::parse(found.out).at("lidar").at("is_mirrored"), true);
  const RobotModel written = read_robot_file(robot);
  EXPECT_TRUE(written.lidars.at(0).upside_down);
  EXPECT_NEAR(written.lidars.at(0).sweep_s, 0.075, 0.004);

  const ProgramResult map = run_program(
      {"map", log, "-o", *folder_ / "anew", "--mcap", *folder_ / "anew.mcap", "--json"});
  ASSERT_EQ(map.exit_code, 0) << map.error;
  EXPECT_THAT(map.error, HasSubstr("upside down"));
  const auto anew = nlohmann::json::parse(map.out);
  EXPECT_EQ(anew.at("calibration").at("beams").at("corrected"), true);
  EXPECT_TRUE(std::filesystem::exists(*folder_ / "anew.mcap"));

  const ProgramResult again =
      run_program({"map", log, "-o", *folder_ / "again", "--robot", robot, "--json"});
  ASSERT_EQ(again.exit_code, 0) << again.error;
  const auto at_once = nlohmann::json::parse(again.out);
  EXPECT_EQ(at_once.at("calibration").at("beams").at("laser_is_mirrored"), false);
  EXPECT_EQ(at_once.at("calibration").at("beams").at("corrected"), false);
  EXPECT_EQ(at_once.at("scans"), anew.at("scans"));
}

}  // namespace
}  // namespace loopstone::test
