// A site: sessions of one building, added on different days.

#include "loopstone/pipeline/site.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/option_list.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/formats/robot_file.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/slam/mapper.hpp"
#include "support/temp_dir.hpp"
#include "support/world_drive.hpp"

namespace loopstone {
namespace {

using test::drive_in;
using test::TempDir;
using test::WorldDrive;
using testing::HasSubstr;

constexpr double kDayS = 86'400.0;

MappedSession mapped(const WorldDrive& drive, const std::string& name, double day) {
  Mapper mapper(RobotModel{}, MapOptions{}, {2});
  for (const SensorMessage& message : drive.messages) mapper.add(message);
  (void)mapper.judge_robot();
  MappedSession session;
  session.session.log = "/logs/" + name;
  session.session.digest = name;
  session.session.begins = Stamp::from_seconds(20'000.0 * kDayS + day * kDayS);
  session.session.robot = robot_to_toml(RobotModel{});
  session.session.verdict = "good";
  session.record =
      std::make_shared<const DriveRecord>(record_of(mapper.save_state().get(), MapOptions{}));
  return session;
}

std::string new_site(const TempDir& folder, const std::string& name) {
  MapOptions options;
  SiteFile::create(folder / name, options_to_toml(list_options(options)));
  return folder / name;
}

/// Of an office on three days, and of a warehouse.
class SiteOfAnOffice : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const World office = make_world("office", 1);
    sessions_ = new std::vector<MappedSession>{
        mapped(drive_in(office, 1, 90.0, 0, 0.0), "monday", 1.0),
        mapped(drive_in(office, 2, 60.0, 3, 0.0), "tuesday", 2.0),
        mapped(drive_in(office, 3, 60.0, 0, 0.0), "wednesday", 3.0),
        mapped(drive_in(make_world("warehouse", 4), 4, 45.0, 0, 0.0), "elsewhere", 4.0)};
  }
  static void TearDownTestSuite() {
    delete sessions_;
    sessions_ = nullptr;
  }
  static std::string site_of(const TempDir& folder, const std::string& name,
                             const std::vector<std::size_t>& order) {
    std::string path = new_site(folder, name);
    Site site(path, SiteAccess::kWrite, {2});
    for (const std::size_t i : order) (void)site.add((*sessions_)[i]);
    return path;
  }

  static inline std::vector<MappedSession>* sessions_ = nullptr;
};

TEST_F(SiteOfAnOffice, TheOrderOfAddingChangesNothing) {
  const TempDir folder;
  const SiteMap one = Site(site_of(folder, "a", {0, 1, 2}), SiteAccess::kRead, {2}).map();
  const SiteMap other = Site(site_of(folder, "b", {2, 0, 1}), SiteAccess::kRead, {1}).map();
  ASSERT_EQ(one.sessions.size(), 3U);
  EXPECT_EQ(format_tum(one.result.trajectory), format_tum(other.result.trajectory));
  EXPECT_EQ(one.result.map.log_odds.cells(), other.result.map.log_odds.cells());
}

TEST_F(SiteOfAnOffice, AnotherBuildingWaitsBesideIt) {
  const TempDir folder;
  Site site(site_of(folder, "a", {0, 3}), SiteAccess::kWrite, {2});
  const std::vector<SiteSession> sessions = site.sessions();
  EXPECT_EQ(sessions[0].status, SessionStatus::kJoined);
  EXPECT_EQ(sessions[1].status, SessionStatus::kPending);
  EXPECT_NE(sessions[1].reason, "");
  EXPECT_EQ(site.map().sessions.size(), 1U);
}

TEST_F(SiteOfAnOffice, ASessionIsAddedOnce) {
  const TempDir folder;
  Site site(site_of(folder, "a", {0}), SiteAccess::kWrite, {2});
  try {
    (void)site.add((*sessions_)[0]);
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), HasSubstr("is in the site already, as session 1"));
  }
  EXPECT_EQ(site.sessions().size(), 1U);
}

TEST_F(SiteOfAnOffice, WhatIsCalledOffLeavesTheSiteAsItWas) {
  const TempDir folder;
  const std::string path = site_of(folder, "a", {0});
  {
    Site site(path, SiteAccess::kWrite, {2});
    EXPECT_THROW(
        (void)site.add((*sessions_)[1], {.progress = [](const Progress&) { return false; }}),
        UsageError);
  }
  EXPECT_EQ(Site(path, SiteAccess::kRead, {2}).sessions().size(), 1U);
  Site site(path, SiteAccess::kWrite, {2});
  EXPECT_EQ(site.add((*sessions_)[1]).status, SessionStatus::kJoined);
}

TEST_F(SiteOfAnOffice, EveryCallCanBeCalledOffAtEveryStep) {
  const TempDir folder;
  const std::string path = site_of(folder, "a", {0, 1, 2});
  const std::string before = format_tum(Site(path, SiteAccess::kRead, {2}).map().result.trajectory);
  const std::vector<std::function<void(Site&, const ProgressCallback&)>> calls{
      [](Site& site, const ProgressCallback& progress) {
        site.remove({3}, {.progress = progress});
      },
      [](Site& site, const ProgressCallback& progress) { site.rebuild({.progress = progress}); },
      [](Site& site, const ProgressCallback& progress) { (void)site.map({}, {}, progress); },
      [](Site& site, const ProgressCallback& progress) {
        (void)site.difference(Stamp::from_seconds(20'001.5 * kDayS),
                              Stamp::from_seconds(20'009.0 * kDayS), progress);
      }};
  for (std::size_t i = 0; i < calls.size(); ++i) {
    for (const int answers : {0, 2, 4}) {
      Site site(path, SiteAccess::kWrite, {2});
      const auto off = [told = 0, answers](const Progress& /*news*/) mutable {
        return told++ < answers;
      };
      EXPECT_THROW(calls[i](site, off), UsageError) << i << ", after " << answers;
    }
    EXPECT_EQ(Site(path, SiteAccess::kRead, {2}).sessions().size(), 3U) << i;
  }
  EXPECT_EQ(format_tum(Site(path, SiteAccess::kRead, {2}).map().result.trajectory), before);
}

TEST_F(SiteOfAnOffice, ARemovedSessionIsAsIfItHadNeverBeenThere) {
  const TempDir folder;
  Site site(site_of(folder, "a", {0, 1, 2}), SiteAccess::kWrite, {2});
  site.remove({2});
  const Site without(site_of(folder, "b", {0, 2}), SiteAccess::kRead, {2});
  EXPECT_EQ(format_tum(site.map().result.trajectory), format_tum(without.map().result.trajectory));
  EXPECT_THROW(site.remove({2}), UsageError);
}

TEST_F(SiteOfAnOffice, TheMapOfADateKnowsNothingOfWhatCameLater) {
  const TempDir folder;
  const Site site(site_of(folder, "a", {0, 1}), SiteAccess::kRead, {2});
  const auto seen = [](const SiteMap& map) {
    std::size_t cells = 0;
    for (const std::uint8_t observed : map.result.map.observed.cells()) cells += observed;
    return cells;
  };
  const SiteMap today = site.map();
  const SiteMap monday = site.map((*sessions_)[0].session.begins);
  EXPECT_LT(seen(monday), seen(today));
  EXPECT_THROW((void)site.map(Stamp{}), DataError);
}

TEST_F(SiteOfAnOffice, ABadMapIsRefusedAndNothingOfItIsKept) {
  const TempDir folder;
  Site site(site_of(folder, "a", {0}), SiteAccess::kWrite, {2});
  MappedSession bad;
  bad.session = {.log = "/logs/bad",
                 .digest = "bad",
                 .status = SessionStatus::kRefused,
                 .reason = "its own map is bad"};
  EXPECT_EQ(site.add(bad).status, SessionStatus::kRefused);
  EXPECT_EQ(site.sessions().size(), 2U);
  EXPECT_TRUE(site.file().check().empty());
  EXPECT_EQ(site.map().sessions.size(), 1U);
}

/// A room of which a shelf is moved between two days.
TEST(Site, WhatWasMovedIsToldAndTheMapIsThatOfToday) {
  World before = make_world("office", 2);
  World after = before;
  const Eigen::Vector2d at = before.map_T_start.translation() + Eigen::Vector2d(1.5, 0.4);
  before.plan.boxes.push_back(
      {.map_T_box = {at.x(), at.y(), 0.0}, .length_m = 0.6, .width_m = 0.6});
  const TempDir folder;
  Site site(new_site(folder, "a"), SiteAccess::kWrite, {2});
  for (int day = 1; day <= 5; ++day) {
    const World& world = day <= 3 ? before : after;
    const auto session = site.add(mapped(
        drive_in(world, static_cast<std::uint64_t>(day), 40.0, 0, 0.0), std::to_string(day), day));
    EXPECT_EQ(session.status, SessionStatus::kJoined) << day;
  }
  const Site::Difference difference = site.difference(
      Stamp::from_seconds((20'000.0 + 3.5) * kDayS), Stamp::from_seconds((20'000.0 + 5.5) * kDayS));
  ASSERT_EQ(difference.changes.size(), 1U);
  const MapChange& change = difference.changes.front();
  EXPECT_FALSE(change.appeared);
  // The frame of the map is where the first drive began.
  const Eigen::Vector2d centre = before.map_T_start.inverse() * at;
  EXPECT_LT((0.5 * (change.low + change.high) - centre).norm(), 0.35);
  // One visit after it was moved, it may have been somebody who stood in the way.
  const Site::Difference early = site.difference(Stamp::from_seconds((20'000.0 + 3.5) * kDayS),
                                                 Stamp::from_seconds((20'000.0 + 4.5) * kDayS));
  EXPECT_TRUE(early.changes.empty());
}

TEST(Site, OldSessionsGoOnceNewOnesShowAllThatTheySaw) {
  const World office = make_world("office", 3);
  const TempDir folder;
  Site site(new_site(folder, "a"), SiteAccess::kWrite, {2});
  const int days = kSite.keep_visits + 3;
  for (int day = 1; day <= days; ++day) {
    const auto seed = static_cast<std::uint64_t>(day);
    (void)site.add(mapped(drive_in(office, seed, 15.0, 0, 0.0), std::to_string(day), day));
  }
  const std::vector<SiteSession> sessions = site.sessions();
  ASSERT_EQ(sessions.size(), static_cast<std::size_t>(days));
  // The first is what the others were compared with: it stays.
  for (int day = 1; day <= days; ++day) {
    const bool is_gone = day > 1 && day <= 3;
    EXPECT_EQ(sessions[static_cast<std::size_t>(day - 1)].status,
              is_gone ? SessionStatus::kRetired : SessionStatus::kJoined)
        << day;
  }
  EXPECT_TRUE(site.file().check().empty());
  EXPECT_EQ(site.map().sessions.size(), static_cast<std::size_t>(kSite.keep_visits + 1));
}

TEST(SiteDates, AreReadAsTheyAreWritten) {
  for (const double seconds : {0.0, 1e9, 1764165780.0, 951782399.0}) {
    const Stamp stamp = Stamp::from_seconds(seconds);
    EXPECT_EQ(parse_utc(utc_text(stamp)), stamp);
  }
  EXPECT_EQ(utc_text(Stamp::from_seconds(1764165780.0)), "2025-11-26T14:03:00Z");
  EXPECT_EQ(parse_utc("2025-11-26"), Stamp::from_seconds(1764115200.0));
  EXPECT_EQ(parse_utc("2025-11-26T14:03"), Stamp::from_seconds(1764165780.0));
  EXPECT_EQ(parse_utc_end("2025-11-26"),
            Stamp::from_seconds(1764115200.0) + Duration::from_seconds(86'400.0 - 1e-9));
  EXPECT_EQ(parse_utc_end("2025-11-26T14:03"), Stamp::from_seconds(1764165780.0));
  EXPECT_FALSE(parse_utc_end("today"));
  for (const char* wrong :
       {"", "today", "2025-13-01", "2025-02-30", "2025-11-26T25:00", "2025-11-26 1"})
    EXPECT_FALSE(parse_utc(wrong)) << wrong;
}

}  // namespace
}  // namespace loopstone
