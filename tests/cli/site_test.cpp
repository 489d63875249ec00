// loopstone site: one map of a building from many drives.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "loopstone/formats/g2o.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/formats/tum.hpp"
#include "run_program.hpp"
#include "support/played_recording.hpp"
#include "support/pose_near.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Json = nlohmann::json;

class SiteCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempDir;
    for (const auto& [name, world, seed, place] : {std::tuple{"monday", "office", "3", "1"},
                                                   {"tuesday", "office", "4", "2"},
                                                   {"elsewhere", "warehouse", "5", "1"}}) {
      const ProgramResult made = run_program({"simulate", world, "-o", *folder_ / name, "--seed",
                                              "3", "--drive-seed", seed, "--start-place", place,
                                              "--duration", "45", "--beams", "361", "--quiet"});
      ASSERT_EQ(made.exit_code, 0) << made.error;
    }
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static ProgramResult site(std::vector<std::string> words) {
    words.insert(words.begin(), "site");
    words.emplace_back("--quiet");
    return run_program(words);
  }
  static ProgramResult add(const std::string& name, const std::string& log,
                           const std::string& date = {}) {
    std::vector<std::string> words{"add", *folder_ / name, *folder_ / log, "--json"};
    if (!date.empty()) words.insert(words.end(), {"--date", date});
    return site(words);
  }
  static Json json_of(const ProgramResult& result) {
    EXPECT_EQ(result.exit_code, 0) << result.error;
    return Json::parse(result.out);
  }

  static std::vector<std::string> split(const std::string& text, char at) {
    std::vector<std::string> parts;
    std::istringstream stream(text);
    for (std::string part; std::getline(stream, part, at);) parts.push_back(part);
    return parts;
  }
  static std::vector<std::string> lines_of_file(const std::string& name) {
    return split(folder_->read(name), '\n');
  }
  static std::vector<std::string> cells_of(const std::string& row) { return split(row, ','); }

  static void expect_same_poses(const GraphFile& one, const GraphFile& other, double within) {
    ASSERT_EQ(one.ids, other.ids);
    for (std::size_t i = 0; i < one.graph.poses.size(); ++i)
      EXPECT_TRUE(pose_near(one.graph.poses[i], other.graph.poses[i], within, within)) << i;
  }

  static inline TempDir* folder_ = nullptr;
};

TEST_F(SiteCommand, SessionsAreJoinedAndDrawnAsOneMap) {
  const Json first = json_of(add("a.site", "monday", "2026-11-02"));
  EXPECT_EQ(first["sessions"][0]["status"], "joined");
  EXPECT_EQ(first["sessions"][0]["begins"], "2026-11-02T00:00:00Z");
  const Json second = json_of(add("a.site", "tuesday", "2026-11-03"));
  EXPECT_EQ(second["sessions"][0]["status"], "joined");
  EXPECT_GT(second["sessions"][0]["closures"], 1);
  const Json third = json_of(add("a.site", "elsewhere", "2026-11-04"));
  EXPECT_EQ(third["sessions"][0]["status"], "pending");
  EXPECT_NE(third["sessions"][0]["reason"], "");

  const Json shown = json_of(site({"show", *folder_ / "a.site", "--ties", "--json"}));
  EXPECT_EQ(shown["joined"], 2);
  EXPECT_EQ(shown["sessions"].size(), 3U);
  EXPECT_FALSE(shown["ties"].empty());
  EXPECT_EQ(json_of(site({"check", *folder_ / "a.site", "--json"}))["sound"], true);
  EXPECT_EQ(json_of(site({"history", *folder_ / "a.site", "--json"}))["events"].size(), 3U);

  const ProgramResult mapped = site({"map", *folder_ / "a.site", "-o", *folder_ / "map", "--json"});
  const Json summary = json_of(mapped);
  EXPECT_EQ(summary["drives"].size(), 1U);
  EXPECT_EQ(summary["site"]["sessions"], 2);
  EXPECT_GT(summary["site"]["free_seen_by_newest_share"], 0.2);
  EXPECT_GT(summary["site"]["speed_m_s"], 0.2);
  EXPECT_TRUE(summary["site"]["glass"].empty());
  for (const char* name : {"map.yaml", "map.pgm", "movable.yaml", "movable.pgm", "movable.png",
                           "coverage.yaml", "coverage.pgm", "coverage.png", "coverage_days.pgm",
                           "travel.pgm", "travel.png", "travel.csv", "glass.pgm", "glass.png",
                           "trajectory_drive_1.tum", "trajectory_drive_2.tum", "report.html"})
    EXPECT_TRUE(fs::exists(fs::path(*folder_ / "map") / name)) << name;
  EXPECT_EQ(json_of(site({"changes", *folder_ / "a.site", "--from", "2026-11-02", "-o",
                          *folder_ / "changes", "--json"}))["changes"]
                .size(),
            0U);
  EXPECT_TRUE(fs::exists(*folder_ / "changes/changes.png"));

  // A robot is located on it.
  const ProgramResult located =
      run_program({"localize", *folder_ / "tuesday", "--map", *folder_ / "a.site", "-o",
                   *folder_ / "where.tum", "--global", "--quiet", "--json"});
  EXPECT_GT(json_of(located)["tracking_share"], 0.8);

  // And goes on without what was not joined.
  EXPECT_EQ(json_of(site({"prune", *folder_ / "a.site", "--pending", "--json"}))["removed"], 1);
  EXPECT_EQ(json_of(site({"rebuild", *folder_ / "a.site", "--json"}))["joined"], 2);
}

/// What leaves a site is the site: its optimum, its sessions, its map.
TEST_F(SiteCommand, WhatIsExportedIsReadBack) {
  ASSERT_EQ(add("export.site", "monday", "2026-11-02").exit_code, 0);
  ASSERT_EQ(add("export.site", "tuesday", "2026-11-03").exit_code, 0);
  const std::string out = *folder_ / "exported";
  const std::string mcap = *folder_ / "export.mcap";
  const Json summary =
      json_of(site({"map", *folder_ / "export.site", "-o", out, "--mcap", mcap, "--json"}));

  // The graph: of all sessions, connected, at its optimum, and poses of both trajectories.
  const GraphFile graph = read_g2o(out + "/graph.g2o");
  require_connected(graph, "graph.g2o");
  EXPECT_EQ(std::set(graph.ids.begin(), graph.ids.end()).size(), graph.graph.poses.size());
  const ProgramResult solved =
      run_program({"optimize", out + "/graph.g2o", "-o", *folder_ / "solved.g2o", "--quiet"});
  ASSERT_EQ(solved.exit_code, 0) << solved.error;
  const GraphFile optimum = read_g2o(*folder_ / "solved.g2o");
  // Its optimum is what the graph alone says; the surfaces that key scans share move them a little.
  expect_same_poses(optimum, graph, 0.05);
  for (const char* day : {"monday", "tuesday"}) {
    ASSERT_EQ(site({"add", *folder_ / "alone.site", *folder_ / day, "--date",
                    day == std::string("monday") ? "2026-11-02" : "2026-11-03", "--set",
                    "adjustment.enabled=false"})
                  .exit_code,
              0);
  }
  ASSERT_EQ(site({"map", *folder_ / "alone.site", "-o", *folder_ / "alone"}).exit_code, 0);
  expect_same_poses(optimum, read_g2o(*folder_ / "alone/graph.g2o"), 1e-6);
  const std::vector<std::string> rows = lines_of_file("exported/sessions.csv");
  ASSERT_EQ(rows.size(), 3U);
  std::size_t nodes = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const std::vector<std::string> cells = cells_of(rows[i]);
    EXPECT_EQ(cells.at(0), std::to_string(i));
    EXPECT_EQ(std::stoul(cells.at(4)), nodes) << "one session after the other";
    nodes += std::stoul(cells.at(5));
    const Trajectory own = read_tum(out + "/" + cells.at(2));
    const Pose2& first = graph.graph.poses[std::stoul(cells.at(4))];
    EXPECT_TRUE(pose_near(own.front().pose, first, 0.1, 0.05)) << "of the graph, not adjusted";
    EXPECT_THAT(rows[i], HasSubstr(i == 1 ? "/monday" : "/tuesday"));
  }
  EXPECT_EQ(nodes, graph.graph.poses.size());

  // The recording: the map as it stands in its file, a path a session, every pose.
  const PlayedRecording played(mcap);
  const CellStates cells = read_ros_map(out + "/map.yaml");
  EXPECT_EQ(played.all<msg::OccupancyGrid>("/map").at(0).value.data, cells.cells());
  EXPECT_EQ(played.all<msg::OccupancyGrid>("/movable").at(0).value.data.size(),
            cells.cells().size());
  for (const char* name : {"1", "2"}) {
    const Trajectory own = read_tum(out + "/trajectory_drive_" + name + ".tum");
    const msg::Path path =
        played.all<msg::Path>("/session_" + std::string(name) + "/path").at(0).value;
    ASSERT_EQ(path.poses.size(), own.poses().size());
    EXPECT_TRUE(pose_near(to_pose2(path.poses.back().pose), own.poses().back().pose, 1e-6, 1e-6));
  }
  const Trajectory all = read_tum(out + "/trajectory.tum");
  const auto transforms = played.all<msg::TFMessage>("/tf");
  ASSERT_EQ(transforms.size(), all.poses().size());
  EXPECT_TRUE(pose_near(to_pose2(transforms.back().value.transforms.at(0).transform),
                        all.poses().back().pose, 1e-6, 1e-6));
  EXPECT_EQ(lines_of(played.all<msg::MarkerArray>("/loop_closures").at(0).value, "standing"),
            summary.at("loop_closures_accepted"));
  EXPECT_EQ(played.all<msg::DiagnosticArray>("/verdict").size(), 1U);

  // It is not written over what is there, nor does it take the map with it.
  EXPECT_EQ(
      site({"map", *folder_ / "export.site", "-o", *folder_ / "other", "--mcap", mcap}).exit_code,
      2);
  const ProgramResult full = site(
      {"map", *folder_ / "export.site", "-o", *folder_ / "full", "--mcap", "/dev/full", "--force"});
  EXPECT_EQ(full.exit_code, 1);
  EXPECT_THAT(full.error, HasSubstr("the recording could not be written"));
  EXPECT_TRUE(fs::exists(*folder_ / "full/map.yaml"));
}

TEST_F(SiteCommand, EditsAreKeptToldAndUndone) {
  const std::string path = *folder_ / "edit.site";
  ASSERT_EQ(add("edit.site", "monday", "2026-11-02").exit_code, 0);
  ASSERT_EQ(add("edit.site", "tuesday", "2026-11-03").exit_code, 0);
  const Json wall =
      json_of(site({"edit", path, "--wall", "-0.4,-0.4 0.4,-0.4 0.4,0.4 -0.4,0.4", "--json"}));
  EXPECT_EQ(wall["edit"], 1);
  const Json left_out = json_of(site({"edit", path, "--exclude", "2", "--json"}));
  EXPECT_EQ(left_out["edits"], 2);
  EXPECT_EQ(left_out["joined"], 1);
  const Json far = json_of(site({"edit", path, "--free", "60,60 61,60 61,61", "--json"}));
  EXPECT_EQ(far["edit"], 3);

  const Json edits = json_of(site({"edits", path, "--json"}))["edits"];
  ASSERT_EQ(edits.size(), 3U);
  EXPECT_EQ(edits[0]["kind"], "wall");
  EXPECT_NEAR(edits[0]["area_m2"].get<double>(), 0.64, 1e-6);
  EXPECT_NEAR(edits[0]["polygon"][0][0].get<double>(), -0.4, 1e-6);
  EXPECT_EQ(edits[1]["kind"], "exclude");
  EXPECT_EQ(edits[1]["session"], 2);
  const ProgramResult told = run_program({"site", "edits", path});
  EXPECT_THAT(told.out, HasSubstr("0.64 m2"));
  EXPECT_THAT(told.out, HasSubstr("session 2 (tuesday)"));
  const Json shown = json_of(site({"show", path, "--json"}));
  EXPECT_EQ(shown["sessions"][1]["status"], "excluded");
  EXPECT_EQ(shown["sessions"][1]["reason"], "left out by edit 2");
  EXPECT_EQ(shown["edits"].size(), 3U);
  EXPECT_EQ(json_of(site({"check", path, "--json"}))["sound"], true);
  const Json events = json_of(site({"history", path, "--json"}))["events"];
  EXPECT_EQ(events[3]["what"], "exclude");
  EXPECT_THAT(events[3]["log"].get<std::string>(), HasSubstr("tuesday"));

  const ProgramResult mapped =
      site({"map", path, "-o", *folder_ / "edited", "--json", "--mcap", *folder_ / "edited.mcap"});
  EXPECT_THAT(mapped.error, HasSubstr("edit 3 lies beside the map"));
  const Json summary = json_of(mapped);
  EXPECT_EQ(summary["site"]["sessions"], 1);
  EXPECT_EQ(summary["site"]["edits"].size(), 3U);
  EXPECT_GT(summary["site"]["edits"][0]["cells"], 250);
  EXPECT_EQ(summary["site"]["edits"][2]["cells"], 0);
  const CellStates cells = read_ros_map(*folder_ / "edited/map.yaml");
  EXPECT_EQ(cells[cells.frame().cell_of({0.1, 0.1})], 100);
  const PlayedRecording played(*folder_ / "edited.mcap");
  EXPECT_EQ(played.all<msg::OccupancyGrid>("/map").at(0).value.data, cells.cells());
  // Monday began where the wall is now; a plan has its sides.
  const ProgramResult plan =
      run_program({"export", path, "--dxf", *folder_ / "edited.dxf", "--quiet", "--json"});
  const double walls_m =
      json_of(plan)["structure_m"].get<double>() + json_of(plan)["movable_m"].get<double>();

  EXPECT_EQ(json_of(site({"changes", path, "--from", "2026-11-02", "-o", *folder_ / "edit_changes",
                          "--json"}))["edits"]
                .size(),
            3U);

  EXPECT_EQ(json_of(site({"edit", path, "--undo", "1", "--json"}))["edits"], 2);
  EXPECT_EQ(json_of(site({"edit", path, "--include", "2", "--json"}))["joined"], 2);
  EXPECT_EQ(json_of(site({"edits", path, "--json"}))["edits"].size(), 1U);
  ASSERT_EQ(site({"edit", path, "--exclude", "2"}).exit_code, 0);
  const Json without = json_of(
      run_program({"export", path, "--dxf", *folder_ / "without.dxf", "--quiet", "--json"}));
  EXPECT_NEAR(walls_m - without["structure_m"].get<double>() - without["movable_m"].get<double>(),
              3.2, 0.4);
}

TEST_F(SiteCommand, EditsThatCanNotBeAreRefused) {
  const std::string path = *folder_ / "wrong.site";
  ASSERT_EQ(add("wrong.site", "monday").exit_code, 0);
  const std::vector<std::pair<std::string, std::vector<std::string>>> cases{
      {"give one of --exclude", {}},
      {"give one of --exclude", {"--exclude", "1", "--undo", "1"}},
      {"there is no session 7", {"--exclude", "7"}},
      {"there is no session 7", {"--include", "7"}},
      {"session 1 is not left out, it is joined", {"--include", "1"}},
      {"there is no edit 4", {"--undo", "4"}},
      {"--wall: 'a,b' is no corner", {"--wall", "0,0 1,0 a,b"}},
      {"--free: a polygon must have three corners", {"--free", "0,0 1,0"}},
      {"--free: a polygon must have three corners", {"--free", ""}},
      {"metres of the map", {"--unknown", "5000,0 5001,0 5001,1"}},
  };
  for (const auto& [why, flags] : cases) {
    std::vector<std::string> words{"edit", path};
    words.insert(words.end(), flags.begin(), flags.end());
    const ProgramResult result = site(words);
    EXPECT_EQ(result.exit_code, 2) << why << result.error;
    EXPECT_THAT(result.error, HasSubstr(why));
  }
  EXPECT_THAT(site({"edit", *folder_ / "none.site", "--undo", "1"}).error,
              HasSubstr("there is no such site"));
  EXPECT_EQ(json_of(site({"history", path, "--json"}))["events"].size(), 1U);
}

TEST_F(SiteCommand, ErrorsSayWhatToDo) {
  EXPECT_THAT(site({"show", *folder_ / "none.site"}).error, HasSubstr("there is no such site"));
  folder_->write("text.site", std::string(4000, 'x'));
  EXPECT_THAT(site({"show", *folder_ / "text.site"}).error, HasSubstr("no site of loopstone"));
  const ProgramResult date = add("date.site", "monday", "yesterday");
  EXPECT_EQ(date.exit_code, 2);
  EXPECT_THAT(date.error, HasSubstr("yesterday is no date"));
  ASSERT_EQ(add("twice.site", "monday").exit_code, 0);
  const ProgramResult twice = add("twice.site", "monday");
  EXPECT_EQ(twice.exit_code, 2);
  EXPECT_THAT(twice.error, HasSubstr("is in the site already, as session 1"));
  EXPECT_EQ(site({"prune", *folder_ / "twice.site", "--session", "77"}).exit_code, 2);
  EXPECT_EQ(site({"map", *folder_ / "twice.site", "-o", *folder_ / "old", "--date", "1961-04-12"})
                .exit_code,
            1);
  EXPECT_EQ(site({}).exit_code, 2);
}

TEST_F(SiteCommand, OfAWatchedFolderEachLogIsAddedOnce) {
  const std::string inbox = *folder_ / "inbox";
  fs::create_directories(inbox);
  const ProgramResult converted =
      run_program({"convert", *folder_ / "monday", inbox + "/monday.mcap", "--quiet"});
  ASSERT_EQ(converted.exit_code, 0) << converted.error;
  folder_->write("inbox/notes.txt", "no log\n");
  const std::vector<std::string> words{
      "watch", *folder_ / "watched.site", inbox, "--once", "--settled", "0"};
  const ProgramResult once = site(words);
  EXPECT_EQ(once.exit_code, 0) << once.error;
  EXPECT_THAT(once.error, HasSubstr("notes.txt"));
  EXPECT_EQ(site(words).exit_code, 0);
  const Json shown = json_of(site({"show", *folder_ / "watched.site", "--json"}));
  EXPECT_EQ(shown["sessions"].size(), 1U);
}

/// Whatever ends the program, and when, costs the session in the making alone.
TEST_F(SiteCommand, KilledAtAnyMomentItLosesNothingThatWasThere) {
  const std::string path = *folder_ / "killed.site";
  ASSERT_EQ(add("killed.site", "monday").exit_code, 0);
  for (int tenths = 1; tenths <= 11; tenths += 2) {
    (void)kill_program(std::chrono::milliseconds(100 * tenths),
                       {"site", "add", path, *folder_ / "tuesday", "--quiet"});
    const Json checked = json_of(site({"check", path, "--json"}));
    EXPECT_EQ(checked["sound"], true) << checked;
    const Json shown = json_of(site({"show", path, "--json"}));
    ASSERT_GE(shown["sessions"].size(), 1U);
    if (shown["sessions"].size() == 2U) break;
  }
  const ProgramResult last = add("killed.site", "tuesday");
  EXPECT_TRUE(last.exit_code == 0 || last.exit_code == 2) << last.error;
  EXPECT_EQ(json_of(site({"show", path, "--json"}))["joined"], 2);
}

}  // namespace
}  // namespace loopstone::test
