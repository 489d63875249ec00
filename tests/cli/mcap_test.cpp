// map --mcap: the run as a recording, beside the same results.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "loopstone/formats/ros_map.hpp"
#include "loopstone/formats/tum.hpp"
#include "office_command.hpp"
#include "run_program.hpp"
#include "support/played_recording.hpp"
#include "support/pose_near.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing::HasSubstr;
using Words = std::vector<std::string>;

constexpr int kInterrupted = 130;

class McapCommand : public OfficeCommand {
 protected:
  static Words map(const TempDir& dir, const Words& more) {
    Words words{"map", log_, "-o", dir / "out", "--quiet"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  /// The recording of a run that left its results in out/.
  static void expect_tells_what_is_in(const TempDir& dir, const std::string& file) {
    const Json summary = Json::parse(dir.read("out/summary.json"));
    const PlayedRecording played(file);
    EXPECT_EQ(played.all<msg::LaserScan>("/scan").size(), summary.at("scans"));
    const auto last_map = played.all<msg::OccupancyGrid>("/map").back().value;
    const CellStates cells = read_ros_map(dir / "out/map.yaml");
    EXPECT_EQ(static_cast<int>(last_map.info.width), cells.frame().columns);
    EXPECT_EQ(static_cast<int>(last_map.info.height), cells.frame().rows);
    EXPECT_EQ(last_map.info.origin.position.x, cells.frame().origin.x());
    EXPECT_EQ(last_map.info.origin.position.y, cells.frame().origin.y());
    EXPECT_EQ(last_map.data, cells.cells());
    const Trajectory trajectory = read_tum(dir / "out/trajectory.tum");
    const msg::Path path = played.all<msg::Path>("/path").back().value;
    ASSERT_FALSE(path.poses.empty());
    EXPECT_EQ(path.poses.back().header.stamp, trajectory.back().stamp);
    EXPECT_TRUE(pose_near(to_pose2(path.poses.back().pose), trajectory.back().pose, 1e-6, 1e-6));
    const auto transforms = played.all<msg::TFMessage>("/tf").back().value.transforms;
    ASSERT_EQ(transforms.size(), 2u);
    EXPECT_TRUE(pose_near(to_pose2(transforms[0].transform) * to_pose2(transforms[1].transform),
                          trajectory.back().pose, 1e-6, 1e-6));
    const auto closures = played.all<msg::MarkerArray>("/loop_closures").back().value;
    EXPECT_EQ(lines_of(closures, "standing"), summary.at("loop_closures_accepted"));
    EXPECT_EQ(lines_of(closures, "waiting") + lines_of(closures, "rejected") +
                  lines_of(closures, "revoked"),
              summary.at("loop_closures_rejected"));
    const auto verdict = played.all<msg::DiagnosticArray>("/verdict").back().value;
    const std::string sentence = summary.at("quality").at("sentence");
    EXPECT_EQ(verdict.status.at(0).message, sentence.empty() ? "not judged" : sentence);
  }
};

TEST_F(McapCommand, TheRunIsRecordedAndTheResultsAreTheSame) {
  const TempDir without;
  ASSERT_EQ(run_program(map(without, {})).exit_code, 0);
  const TempDir with;
  const ProgramResult result = run_program(map(with, {"--mcap", with / "run.mcap"}));
  ASSERT_EQ(result.exit_code, 0) << result.error;
  expect_tells_what_is_in(with, with / "run.mcap");
  EXPECT_EQ(with.names(), (Words{"out", "run.mcap"}));
  int files = 0;
  for (const auto& entry : fs::directory_iterator(without / "out")) {
    const std::string name = entry.path().filename().string();
    // Both tell times.
    if (name == "summary.json" || name == "report.html") continue;
    ++files;
    EXPECT_TRUE(without.read("out/" + name) == with.read("out/" + name)) << name;
  }
  EXPECT_GE(files, 8);
}

TEST_F(McapCommand, WhatCtrlCLeavesIsWhole) {
  const TempDir dir;
  const std::string session = dir / "out/session.loopstone";
  const ProgramResult result = interrupt_program(
      session, map(dir, {"--mcap", dir / "run.mcap", "--realtime", "6", "--checkpoint", "0.05"}));
  ASSERT_EQ(result.exit_code, kInterrupted) << result.error;
  expect_tells_what_is_in(dir, dir / "run.mcap");
}

TEST_F(McapCommand, WhatCanNotBeRecordedIsRefusedBeforeTheWork) {
  const TempDir dir;
  dir.write("there.mcap", "precious");
  const std::map<std::string, Words> cases{
      {"leave out one of them", {"--mcap", dir / "a.mcap", "--resume"}},
      {"leave out --pipeline", {"--mcap", dir / "a.mcap", "--pipeline", "scan_to_scan"}},
      {"there.mcap: exists", {"--mcap", dir / "there.mcap"}},
      {"lies in the folder of -o", {"--mcap", dir / "out/run.mcap"}},
      {"what this command reads", {"--mcap", log_ + "/Hokuyo20.npz", "--force"}},
  };
  for (const auto& [why, flags] : cases) {
    const ProgramResult result = run_program(map(dir, flags));
    EXPECT_EQ(result.exit_code, 2) << why << ": " << result.error;
    EXPECT_THAT(result.error, HasSubstr(why));
  }
  EXPECT_EQ(dir.names(), Words{"there.mcap"});
  EXPECT_EQ(dir.read("there.mcap"), "precious");
}

TEST_F(McapCommand, ARecordingThatFailsDoesNotTakeTheMapWithIt) {
  const TempDir dir;
  const ProgramResult result = run_program(map(dir, {"--mcap", "/dev/full"}));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.error, HasSubstr("the recording could not be written: /dev/full"));
  EXPECT_THAT(result.error, HasSubstr("all else is in"));
  EXPECT_TRUE(fs::exists(dir / "out/map.pgm"));
  const Json summary = Json::parse(dir.read("out/summary.json"));
  EXPECT_EQ(summary.at("complete"), false);
  EXPECT_THAT(summary.at("warnings").back(), HasSubstr("/dev/full"));
}

}  // namespace
}  // namespace loopstone::test
