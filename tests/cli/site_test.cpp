// loopstone site: one map of a building from many drives.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <vector>

#include "run_program.hpp"
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
