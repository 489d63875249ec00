// loopstone edit: a finished map is put right by hand.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/formats/ros_map.hpp"
#include "loopstone/formats/tum.hpp"
#include "run_program.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;
using Json = nlohmann::json;
using Words = std::vector<std::string>;

class EditCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempDir;
    const ProgramResult made = run_program({"simulate", "office", "-o", *folder_ / "sim", "--seed",
                                            "3", "--duration", "90", "--beams", "271", "--quiet"});
    ASSERT_EQ(made.exit_code, 0) << made.error;
    const ProgramResult mapped =
        run_program({"map", *folder_ / "sim", "-o", *folder_ / "map", "--keep-state", "--quiet"});
    ASSERT_EQ(mapped.exit_code, 0) << mapped.error;
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static ProgramResult edit(const std::string& of, const std::string& toml, const std::string& out,
                            Words more = {}) {
    const std::string edits = folder_->write(out + ".toml", toml);
    more.insert(more.begin(),
                {"edit", *folder_ / of, "--edits", edits, "-o", *folder_ / out, "--quiet"});
    return run_program(more);
  }
  static Json summary_of(const std::string& out) {
    return Json::parse(folder_->read(out + "/summary.json"));
  }
  /// A closure of the map that stands, as an edit names it.
  static std::string deletion() {
    const std::string csv = folder_->read("map/loop_closures.csv");
    std::size_t line = csv.find('\n') + 1;
    while (line < csv.size()) {
      const std::string row = csv.substr(line, csv.find('\n', line) - line);
      line += row.size() + 1;
      if (row.find(",standing,") == std::string::npos) continue;
      const std::size_t comma = row.find(',');
      return "[[edit]]\nkind = \"delete_closure\"\nfrom_t_s = \"" + row.substr(0, comma) +
             "\"\nto_t_s = \"" + row.substr(comma + 1, row.find(',', comma + 1) - comma - 1) +
             "\"\n";
    }
    ADD_FAILURE() << "no closure stands";
    return {};
  }
  /// The files that must be the same bytes whoever makes them.
  static Words results() {
    return {"trajectory.tum", "trajectory.csv",    "odometry.tum", "graph.g2o",  "map.pgm",
            "map.yaml",       "loop_closures.csv", "map.png",      "quality.png"};
  }

  static inline TempDir* folder_ = nullptr;
};

constexpr const char* kEverything = R"(
[[edit]]
kind = "ignore"
from_s = 30
to_s = 33

[[edit]]
kind = "straighten"

[[edit]]
kind = "origin"
x_m = 1.0
y_m = 0.5

[[edit]]
kind = "crop"
box = [-20, -20, 20, 20]

[[edit]]
kind = "erase"
polygon = [[0, 0], [2, 0], [2, 2]]

[[edit]]
kind = "keep_out"
name = "stairs"
polygon = [[3, 0], [5, 0], [5, 1], [3, 1]]

[[edit]]
kind = "speed"
name = "ramp"
box = [0, 0, 2, 2]
limit_m_s = 0.3
)";

TEST_F(EditCommand, WithoutEditsItMakesTheSameFiles) {
  const ProgramResult result = edit("map", "# nothing\n", "same");
  ASSERT_EQ(result.exit_code, 0) << result.error;
  for (const std::string& name : results())
    EXPECT_EQ(folder_->read("same/" + name), folder_->read("map/" + name)) << name;
  EXPECT_EQ(folder_->read("same/state.loopstone"), folder_->read("map/state.loopstone"));
  EXPECT_EQ(folder_->read("same/edits.toml"), "# nothing\n");
  const Json summary = summary_of("same");
  EXPECT_EQ(summary.at("complete"), true);
  EXPECT_EQ(summary.at("quality").at("verdict"), summary_of("map").at("quality").at("verdict"));
  EXPECT_EQ(summary.at("edits").at("list").size(), 0U);
}

TEST_F(EditCommand, TheSameBytesEachTimeAndForAnyNumberOfThreads) {
  const std::string toml = deletion() + kEverything;
  for (const auto& [out, threads] : {std::pair{"one", "1"}, {"two", "2"}, {"again", "2"}}) {
    const ProgramResult result = edit("map", toml, out, {"--threads", threads});
    ASSERT_EQ(result.exit_code, 0) << result.error;
  }
  Words names = results();
  names.insert(names.end(), {"edits.toml", "keepout_mask.pgm", "keepout_mask.yaml",
                             "speed_mask.pgm", "speed_mask.yaml", "nav2_filters.yaml"});
  for (const std::string& name : names) {
    EXPECT_FALSE(folder_->read("one/" + name).empty()) << name;
    EXPECT_EQ(folder_->read("one/" + name), folder_->read("two/" + name)) << name;
    EXPECT_EQ(folder_->read("two/" + name), folder_->read("again/" + name)) << name;
  }
  const Json edits = summary_of("one").at("edits");
  EXPECT_EQ(edits.at("list").size(), 8U);
  EXPECT_EQ(edits.at("list")[0].at("kind"), "delete_closure");
  EXPECT_EQ(edits.at("zones").at("keep_out")[0].at("name"), "stairs");
  // Masks lie on the map as it is now.
  EXPECT_EQ(read_ros_map(*folder_ / "one/keepout_mask.yaml").frame(),
            read_ros_map(*folder_ / "one/map.yaml").frame());
  EXPECT_THAT(read_ros_map(*folder_ / "one/keepout_mask.yaml").cells(), Contains(std::int8_t{100}));
  EXPECT_THAT(folder_->read("one/loop_closures.csv"), HasSubstr("deleted by hand"));
  EXPECT_THAT(folder_->read("one/report.html"), HasSubstr("Edits by hand"));
}

TEST_F(EditCommand, AnEditedMapCanBeEditedFurther) {
  ASSERT_EQ(edit("map", "[[edit]]\nkind = \"origin\"\nx_m = 2\ny_m = 1\n", "first").exit_code, 0);
  const ProgramResult result =
      edit("first", "[[edit]]\nkind = \"origin\"\nx_m = -2\ny_m = -1\n", "back");
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(folder_->read("back/edits.toml"), HasSubstr("as_edited"));
  const Trajectory there = read_tum(*folder_ / "map/trajectory.tum");
  const Trajectory back = read_tum(*folder_ / "back/trajectory.tum");
  ASSERT_EQ(back.size(), there.size());
  EXPECT_NEAR((back.back().pose.translation() - there.back().pose.translation()).norm(), 0.0, 1e-6);
  // Going on with it would find again what was deleted.
  const ProgramResult drive = run_program(
      {"map", *folder_ / "sim", "--continue", *folder_ / "first", "-o", *folder_ / "no"});
  EXPECT_EQ(drive.exit_code, 1);
  EXPECT_THAT(drive.error, HasSubstr("edited"));
  EXPECT_FALSE(fs::exists(*folder_ / "no"));
}

TEST_F(EditCommand, CheckSaysWhatWouldHappenAndWritesNothing) {
  const std::string edits = folder_->write("check.toml", deletion() + kEverything);
  const Words before = folder_->names();
  const ProgramResult result =
      run_program({"edit", *folder_ / "map", "--edits", edits, "--check", "--quiet"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.out, AllOf(HasSubstr("1 delete_closure"), HasSubstr("is out"),
                                HasSubstr("key scans moved"), HasSubstr("3 straighten")));
  const ProgramResult json =
      run_program({"edit", *folder_ / "map", "--edits", edits, "--check", "--json", "--quiet"});
  EXPECT_EQ(Json::parse(json.out).at("list").size(), 8U);
  EXPECT_EQ(folder_->names(), before);
}

TEST_F(EditCommand, RefusedEditsAreAllToldAndLeaveNothing) {
  const ProgramResult result = edit("map", R"([[edit]]
kind = "add_closure"
from_s = 5
to_s = 6

[[edit]]
kind = "straighten"

[[edit]]
kind = "delete_closure"
from_submap = 0
to_submap = 4000
)",
                                    "refused");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.error, AllOf(HasSubstr("refused.toml:1: edit 1 (add_closure) is refused"),
                                  HasSubstr("neighbours"),
                                  HasSubstr("refused.toml:9: edit 3 (delete_closure) is refused"),
                                  Not(HasSubstr("straighten"))));
  EXPECT_FALSE(fs::exists(*folder_ / "refused"));
}

TEST_F(EditCommand, WhatIsNoEditIsUsageWithLines) {
  const ProgramResult result = edit("map", "[[edit]]\nkind = \"crop\"\nboxx = [0, 0, 1, 1]\n", "x");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.error, AllOf(HasSubstr("x.toml:3: "), HasSubstr("did you mean box?")));
  EXPECT_FALSE(fs::exists(*folder_ / "x"));
}

TEST_F(EditCommand, SaysWhatIsMissing) {
  const ProgramResult plain =
      run_program({"map", *folder_ / "sim", "-o", *folder_ / "plain", "--max-scans", "40", "-q"});
  ASSERT_EQ(plain.exit_code, 0) << plain.error;
  const ProgramResult none = edit("plain", "", "no");
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.error, HasSubstr("--keep-state"));
  EXPECT_EQ(edit("sim", "", "no").exit_code, 1);
  EXPECT_EQ(edit("map", "", "map").exit_code, 2);  // into itself
  const ProgramResult nowhere = run_program(
      {"edit", *folder_ / "map", "--edits", *folder_ / "absent.toml", "-o", *folder_ / "no"});
  EXPECT_EQ(nowhere.exit_code, 1);
  const ProgramResult both =
      run_program({"edit", *folder_ / "map", "--edits", *folder_ / "absent.toml", "--check", "-o",
                   *folder_ / "no"});
  EXPECT_EQ(both.exit_code, 2);
  EXPECT_FALSE(fs::exists(*folder_ / "no"));
}

TEST_F(EditCommand, InterruptedItLeavesAllOrNothing) {
  const std::string edits = folder_->write("interrupted.toml", kEverything);
  const std::string out = *folder_ / "interrupted";
  const ProgramResult result =
      interrupt_program(out, {"edit", *folder_ / "map", "--edits", edits, "-o", out, "--quiet"});
  // The folder is made when there is nothing left but to write: that is done to its end.
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(summary_of("interrupted").at("complete"), true);
  for (const auto& entry : fs::directory_iterator(out))
    EXPECT_THAT(entry.path().filename().string(), Not(HasSubstr(".partial")));
  // While it reads, nothing is there yet.
  const std::string pipe = *folder_ / "pipe.toml";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const ProgramResult early =
      interrupt_reader(pipe, {"edit", *folder_ / "map", "--edits", pipe, "-o", *folder_ / "early"});
  EXPECT_EQ(early.exit_code, 130) << early.error;
  EXPECT_FALSE(fs::exists(*folder_ / "early"));
}

}  // namespace
}  // namespace loopstone::test
