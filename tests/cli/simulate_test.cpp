#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

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
      {{"office", "--format", "bag"}, 2, "--format"},
      {{"office", "--scan-rate", "90"}, 2, "sweep"},
      {{"office", "--set", "laser.noize_m=1"}, 2, "laser.noise_m"},
      {{"missing.yaml"}, 1, "missing.yaml"},
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
