#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <variant>
#include <vector>

#include "loopstone/formats/image.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/formats/tum.hpp"
#include "run_program.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// Every scan of the log has a pose in the truth with its very stamp.
void expect_truth_for_every_scan(const std::string& log_path, const std::string& truth_path) {
  const Trajectory truth = read_tum(truth_path);
  const auto log = open_log(log_path);
  std::size_t scans = 0;
  while (const auto message = log->next()) {
    if (!std::holds_alternative<LaserScan>(*message)) continue;
    ++scans;
    EXPECT_TRUE(truth.nearest(stamp_of(*message), Duration{1000})) << "scan " << scans;
  }
  EXPECT_EQ(scans, truth.size());
  EXPECT_GT(scans, 50U);
}

TEST(SimulateCommand, LeavesLogTruthMapAndDescription) {
  TempDir folder;
  for (const std::string format : {"ucsd", "carmen"}) {
    const std::string output = folder / format;
    const ProgramResult run =
        run_program({"simulate", "office", "-o", output, "--format", format, "--duration", "10",
                     "--beams", "181", "--fov", "180", "--seed", "3", "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.error;
    const auto result = nlohmann::json::parse(run.out);
    EXPECT_NEAR(result["scans"].get<int>(), 100, 1);
    EXPECT_TRUE(result["complete"].get<bool>());
    expect_truth_for_every_scan(result["log"], output + "/truth.tum");
    const CellStates map = read_ros_map(output + "/map.yaml");
    EXPECT_EQ(map[map.frame().cell_of(read_tum(output + "/truth.tum").front().pose.translation())],
              kFreeCell);
    const auto description = nlohmann::json::parse(bytes_of(output + "/world.json"));
    EXPECT_EQ(description["options"]["laser"]["beams"].get<int>(), 181);
    EXPECT_EQ(description["seed"].get<int>(), 3);
  }
}

TEST(SimulateCommand, SameArgumentsSameBytes) {
  TempDir folder;
  for (const std::string name : {"a", "b"}) {
    ASSERT_EQ(run_program({"simulate", "rooms", "-o", folder / name, "--duration", "6", "--people",
                           "3", "--beams", "91"})
                  .exit_code,
              0);
  }
  int files = 0;
  for (const auto& entry : fs::directory_iterator(folder / "a")) {
    const fs::path other = fs::path(folder / "b") / entry.path().filename();
    EXPECT_EQ(bytes_of(entry.path()), bytes_of(other)) << entry.path();
    ++files;
  }
  EXPECT_GE(files, 7);
}

TEST(SimulateCommand, RealismIsTold) {
  TempDir folder;
  const std::vector<std::string> arguments{"simulate",   "rooms", "--format", "carmen",
                                           "--beams",    "91",    "--set",    "laser.rate_hz=5",
                                           "--duration", "20"};
  const auto description_of = [&](const std::string& output, const std::vector<std::string>& more) {
    std::vector<std::string> all = arguments;
    all.insert(all.end(), {"-o", output});
    all.insert(all.end(), more.begin(), more.end());
    const ProgramResult run = run_program(all);
    EXPECT_EQ(run.exit_code, 0) << run.error;
    return nlohmann::json::parse(bytes_of(output + "/world.json"));
  };
  const auto clean = description_of(folder / "clean", {});
  EXPECT_FALSE(clean.contains("realism"));
  EXPECT_FALSE(clean["options"].contains("realism"));
  const auto none = description_of(folder / "none", {"--realism", "none"});
  EXPECT_EQ(bytes_of(folder / "clean/log.clf"), bytes_of(folder / "none/log.clf"));

  const std::string output = folder / "real";
  const auto real = description_of(
      output, {"--realism", "blocked,mount,turned", "--set", "realism.blocked.at_s=8"});
  EXPECT_EQ(real["realism"]["effects"], (std::vector<std::string>{"mount", "blocked", "turned"}));
  EXPECT_TRUE(real["realism"]["drawn"]["mount"].contains("robot_T_lidar_yaw_rad"));
  EXPECT_NE(real["realism"]["drawn"]["turned"]["yaw_rad"].get<double>(), 0.0);
  ASSERT_EQ(real["realism"]["spoils"].size(), 1U);
  EXPECT_EQ(real["realism"]["spoils"][0]["from_stamp_s"].get<double>(), 1008.0);
  EXPECT_EQ(real["realism"]["spoils"][0]["to_s"].get<double>(), 20.0) << "with the log";
  EXPECT_TRUE(real["options"]["realism"]["blocked"]["on"].get<bool>());
  expect_truth_for_every_scan(output + "/log.clf", output + "/truth.tum");
  // The true map is turned with the world: the robot stands on its free floor.
  const CellStates map = read_ros_map(output + "/map.yaml");
  const Trajectory truth = read_tum(output + "/truth.tum");
  for (const StampedPose2& pose : truth.poses())
    EXPECT_EQ(map[map.frame().cell_of(pose.pose.translation())], kFreeCell);
}

TEST(SimulateCommand, TakesPicturesInTheLayoutOfTheRobot) {
  TempDir folder;
  const std::string output = folder / "seen";
  const ProgramResult run =
      run_program({"simulate", "rooms", "-o", output, "--rgbd", "--floor", "text", "--duration",
                   "1", "--beams", "19", "--set", "camera.clock_offset_s=0.03", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.error;
  EXPECT_EQ(run.error.find("warning"), std::string::npos) << run.error;
  const int frames = nlohmann::json::parse(run.out)["frames"].get<int>();
  EXPECT_GE(frames, 4);
  const Image colour = read_image(output + "/dataRGBD/RGB20/rgb20_1.png");
  EXPECT_EQ(colour.width, 640);
  EXPECT_EQ(colour.height, 480);
  EXPECT_EQ(colour.channels, 3);
  const Image disparity = read_image(output + "/dataRGBD/Disparity20/disparity20_1.png");
  EXPECT_EQ(disparity.width, 640);
  EXPECT_EQ(disparity.bytes_per_sample, 2);
  EXPECT_EQ(disparity.channels, 1);
  // The middle of the lowest row sees the floor half a metre ahead.
  const double per_m = (-0.00304 * disparity.sample(479, 320) + 3.31) / 1.03;
  EXPECT_NEAR(1.0 / per_m, 0.5, 0.1);
  int read = 0;
  const auto log = open_log(output);
  while (const auto message = log->next()) {
    const auto* frame = std::get_if<RgbdFrame>(&*message);
    if (frame == nullptr) continue;
    ++read;
    EXPECT_TRUE(fs::exists(frame->colour_path)) << frame->colour_path;
    EXPECT_TRUE(fs::exists(frame->depth_path));
    EXPECT_NEAR((frame->colour_stamp - frame->stamp).seconds(), 0.013, 1e-6);
  }
  EXPECT_EQ(read, frames);

  const auto description = nlohmann::json::parse(bytes_of(output + "/world.json"));
  EXPECT_EQ(description["floor"].get<std::string>(), "text");
  EXPECT_NEAR(description["camera"]["clock_offset_s"].get<double>(), 0.03, 1e-12);
  EXPECT_NEAR(description["camera"]["robot_T_camera"]["pitch_rad"].get<double>(), 0.3775, 1e-9);

  // The floor lies on the map's frame, in cells of 1 cm.
  const CellStates map = read_ros_map(output + "/map.yaml");
  const Image floor = read_image(output + "/floor.png");
  EXPECT_EQ(floor.width, 5 * map.frame().columns);
  EXPECT_EQ(floor.height, 5 * map.frame().rows);
  EXPECT_THAT(bytes_of(output + "/floor.yaml"), HasSubstr("resolution: 0.01"));
  EXPECT_GT(count_lines(bytes_of(output + "/floor_letters.csv")), 1000U);
}

TEST(SimulateCommand, TheFloorMayBeAPicture) {
  TempDir folder;
  Image picture = make_image(2, 1, 3);
  picture.bytes = {250, 10, 10, 10, 250, 10};
  write_png(folder / "floor.png", picture);
  const std::string output = folder / "seen";
  const ProgramResult run =
      run_program({"simulate", "rooms", "-o", output, "--rgbd", "--floor", folder / "floor.png",
                   "--floor-width", "0.1", "--duration", "1", "--beams", "19"});
  ASSERT_EQ(run.exit_code, 0) << run.error;
  const Image floor = read_image(output + "/floor.png");
  int red = 0;
  for (int column = 0; column < 100; ++column) {
    if (floor.sample(3, column, 0) == 250) ++red;
  }
  EXPECT_EQ(red, 50);
}

TEST(SimulateCommand, DrivesOnAMapThatItWroteItself) {
  TempDir folder;
  ASSERT_EQ(
      run_program({"simulate", "rooms", "-o", folder / "first", "--duration", "1", "--beams", "3"})
          .exit_code,
      0);
  const ProgramResult run =
      run_program({"simulate", folder / "first/map.yaml", "-o", folder / "second", "--duration",
                   "10", "--beams", "91", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.error;
  EXPECT_EQ(read_ros_map(folder / "first/map.yaml").cells(),
            read_ros_map(folder / "second/map.yaml").cells());
}

TEST(SimulateCommand, RefusesWhatMakesNoSense) {
  TempDir folder;
  const std::string output = folder / "out";
  struct Case {
    std::vector<std::string> arguments;
    int exit_code;
    std::string says;
  };
  const std::vector<Case> cases{
      {{"ofice"}, 2, "office, campus"},
      {{"office", "--duration", "-1"}, 2, "--duration"},
      {{"office", "--fov", "400"}, 2, "--fov"},
      {{"office", "--beams", "1"}, 2, "--beams"},
      {{"office", "--format", "pcap"}, 2, "--format"},
      {{"office", "--scan-rate", "90"}, 2, "sweep"},
      {{"office", "--set", "laser.noize_m=1"}, 2, "laser.noise_m"},
      {{"office", "--realism", "blocked,fog"}, 2, "upside_down"},
      {{"office", "--set", "realism.blocked.share=1"}, 2, "realism.blocked"},
      {{"missing.yaml"}, 1, "missing.yaml"},
      {{"office", "--floor", "wood"}, 2, "--rgbd"},
      {{"office", "--rgbd", "--floor", "lava"}, 2, "tiles, carpet"},
      {{"office", "--rgbd", "--floor", "missing.png"}, 1, "missing.png"},
      {{"office", "--rgbd", "--format", "carmen"}, 2, "ucsd"},
      {{"office", "--rgbd", "--set", "camera.rate_h=3"}, 2, "camera.rate_hz"},
  };
  for (const Case& each : cases) {
    std::vector<std::string> arguments{"simulate", "-o", output};
    arguments.insert(arguments.end(), each.arguments.begin(), each.arguments.end());
    const ProgramResult run = run_program(arguments);
    EXPECT_EQ(run.exit_code, each.exit_code) << each.arguments.back() << ": " << run.error;
    EXPECT_THAT(run.error, HasSubstr(each.says));
    EXPECT_FALSE(fs::exists(output + "/truth.tum"));
  }
}

TEST(SimulateCommand, KeepsAFolderThatHoldsSomethingUnlessForced) {
  TempDir folder;
  std::ofstream(folder / "mine.txt") << "keep";
  const std::vector<std::string> arguments{"simulate",   "rooms", "-o",      folder / "",
                                           "--duration", "1",     "--beams", "3"};
  EXPECT_EQ(run_program(arguments).exit_code, 2);
  std::vector<std::string> forced = arguments;
  forced.emplace_back("--force");
  EXPECT_EQ(run_program(forced).exit_code, 0);
  EXPECT_EQ(bytes_of(folder / "mine.txt"), "keep");
}

}  // namespace
}  // namespace loopstone::test
