// A site: sessions of one building, added on different days.

#include "loopstone/pipeline/site.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/option_list.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/formats/robot_file.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/mapping/map_touch_up.hpp"
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
      [](Site& site, const ProgressCallback& progress) {
        (void)site.exclude(2, {.progress = progress});
      },
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
    const Site left(path, SiteAccess::kRead, {2});
    EXPECT_EQ(left.sessions().size(), 3U) << i;
    EXPECT_TRUE(left.edits().empty()) << i;
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

TEST_F(SiteOfAnOffice, AnExcludedSessionIsAsIfItHadNeverBeenThereAndComesBack) {
  const TempDir folder;
  const std::string path = site_of(folder, "a", {0, 1, 2});
  const auto map_of = [&](const std::string& of) {
    const SiteMap map = Site(of, SiteAccess::kRead, {2}).map();
    return std::pair(format_tum(map.result.trajectory), map.result.map.log_odds.cells());
  };
  const auto before = map_of(path);
  EXPECT_EQ(Site(path, SiteAccess::kWrite, {2}).exclude(2).id, 1);
  EXPECT_EQ(map_of(path), map_of(site_of(folder, "b", {0, 2})));
  {
    const Site site(path, SiteAccess::kRead, {2});
    EXPECT_EQ(site.sessions()[1].status, SessionStatus::kExcluded);
    EXPECT_EQ(site.map().edits.size(), 1U);
    EXPECT_TRUE(site.file().check().empty());
  }
  EXPECT_THROW(Site(path, SiteAccess::kWrite, {2}).exclude(2), UsageError) << "it is already";
  EXPECT_THROW(Site(path, SiteAccess::kWrite, {2}).exclude(77), UsageError);
  EXPECT_THROW(Site(path, SiteAccess::kWrite, {2}).include(1), UsageError);
  EXPECT_THROW(Site(path, SiteAccess::kWrite, {2}).undo(2), UsageError);
  // What is added meanwhile does not bring it back, and in the end the order changes nothing.
  EXPECT_EQ(Site(path, SiteAccess::kWrite, {2}).include(2).id, 1);
  EXPECT_TRUE(Site(path, SiteAccess::kRead, {2}).edits().empty());
  EXPECT_EQ(map_of(path), before);
}

TEST_F(SiteOfAnOffice, WhatIsAddedWhileASessionIsExcludedIsJoinedWithoutIt) {
  const TempDir folder;
  const std::string path = site_of(folder, "a", {0, 1});
  Site(path, SiteAccess::kWrite, {2}).exclude(2);
  EXPECT_EQ(Site(path, SiteAccess::kWrite, {2}).add((*sessions_)[2]).status,
            SessionStatus::kJoined);
  const Site without(site_of(folder, "b", {0, 2}), SiteAccess::kRead, {2});
  EXPECT_EQ(format_tum(Site(path, SiteAccess::kRead, {2}).map().result.trajectory),
            format_tum(without.map().result.trajectory));
  Site(path, SiteAccess::kWrite, {2}).undo(1);
  const Site all(site_of(folder, "c", {0, 1, 2}), SiteAccess::kRead, {2});
  EXPECT_EQ(format_tum(Site(path, SiteAccess::kRead, {2}).map().result.trajectory),
            format_tum(all.map().result.trajectory));
}

/// Of the cells whose centres lie in a polygon, the share that says so.
double share_of(const OccupancyMap& map, const Polygon2& polygon, SiteEditKind kind) {
  double cells = 0.0;
  double right = 0.0;
  for_each_cell_in(polygon, map.observed.frame(), [&](Cell cell) {
    cells += 1.0;
    const bool seen = map.observed[cell] != 0;
    const double p = map.probability(cell);
    const bool is_right = kind == SiteEditKind::kUnknown ? !seen
                          : kind == SiteEditKind::kWall  ? seen && p > 0.9
                                                         : seen && p < 0.1;
    right += is_right ? 1.0 : 0.0;
  });
  return cells > 0.0 ? right / cells : 0.0;
}

TEST_F(SiteOfAnOffice, PolygonsHoldOnEveryMapAndTheLastOneCounts) {
  const TempDir folder;
  const std::string path = site_of(folder, "a", {0, 1});
  const Polygon2 wall = box_polygon({0.5, -0.4}, {1.0, 0.4});
  const Polygon2 half = box_polygon({0.5, 0.0}, {1.0, 0.4});
  const auto wall_share = [&](const OccupancyMap& map) {
    return share_of(map, wall, SiteEditKind::kWall);
  };
  EXPECT_LT(wall_share(Site(path, SiteAccess::kRead, {2}).map().result.map), 0.1);
  EXPECT_EQ(Site(path, SiteAccess::kWrite, {2}).set_cells(SiteEditKind::kWall, wall).id, 1);
  const SiteMap map = Site(path, SiteAccess::kRead, {2}).map();
  EXPECT_EQ(wall_share(map.result.map), 1.0);
  ASSERT_EQ(map.edits.size(), 1U);
  EXPECT_GE(map.edits[0].cells, 160);
  EXPECT_EQ(
      wall_share(Site(path, SiteAccess::kRead, {2}).map((*sessions_)[0].session.begins).result.map),
      1.0);
  const Site::Difference difference =
      Site(path, SiteAccess::kRead, {2}).difference((*sessions_)[0].session.begins);
  EXPECT_EQ(wall_share(difference.before), 1.0);
  EXPECT_EQ(wall_share(difference.now.result.map), 1.0);

  (void)Site(path, SiteAccess::kWrite, {2}).set_cells(SiteEditKind::kUnknown, half);
  (void)Site(path, SiteAccess::kWrite, {2})
      .set_cells(SiteEditKind::kFree, box_polygon({3.0, 3.0}, {9.0, 9.0}));
  const SiteMap later = Site(path, SiteAccess::kRead, {2}).map();
  EXPECT_EQ(share_of(later.result.map, half, SiteEditKind::kUnknown), 1.0);
  EXPECT_EQ(share_of(later.result.map, *later.edits[2].on_map, SiteEditKind::kFree), 1.0);
  Site(path, SiteAccess::kWrite, {2}).undo(2);
  EXPECT_EQ(wall_share(Site(path, SiteAccess::kRead, {2}).map().result.map), 1.0);
  EXPECT_EQ(Site(path, SiteAccess::kRead, {2}).file().events().back().what, "undo");
  EXPECT_THROW((void)Site(path, SiteAccess::kWrite, {2})
                   .set_cells(SiteEditKind::kFree, box_polygon({3000.0, 3.0}, {3009.0, 9.0})),
               UsageError);
  EXPECT_THROW((void)Site(path, SiteAccess::kWrite, {2}).set_cells(SiteEditKind::kFree, {}),
               UsageError);
  EXPECT_THROW((void)Site(new_site(folder, "empty"), SiteAccess::kWrite, {2})
                   .set_cells(SiteEditKind::kFree, wall),
               DataError);
}

/// The oldest session gives the map its frame and carries the polygon: without it both are
/// elsewhere, and the polygon stays on the building.
TEST_F(SiteOfAnOffice, APolygonGoesWithTheBuildingWhenTheMapMoves) {
  const TempDir folder;
  const std::string path = site_of(folder, "a", {0, 1});
  const Polygon2 wall = box_polygon({0.5, -0.4}, {1.0, 0.4});
  (void)Site(path, SiteAccess::kWrite, {2}).set_cells(SiteEditKind::kWall, wall);
  const auto tuesday = [&](std::size_t drive) {
    const SiteMap map = Site(path, SiteAccess::kRead, {2}).map();
    return map.result.trajectories().at(drive).front().pose;
  };
  const Pose2 first_T_tuesday = tuesday(1);
  const auto expect_wall_on_tuesday = [&](std::size_t drive, double within_m) {
    const std::vector<SiteCorrection> edits = Site(path, SiteAccess::kRead, {2}).edits();
    ASSERT_TRUE(edits.at(0).on_map);
    const Polygon2 moved = tuesday(drive) * first_T_tuesday.inverse() * wall;
    for (std::size_t i = 0; i < moved.corners.size(); ++i)
      EXPECT_LT((moved.corners[i] - edits.at(0).on_map->corners[i]).norm(), within_m) << i;
  };
  expect_wall_on_tuesday(1, 1e-6);
  Site(path, SiteAccess::kWrite, {2}).exclude(1);
  EXPECT_GT((tuesday(0).translation() - first_T_tuesday.translation()).norm(), 0.5);
  expect_wall_on_tuesday(0, 0.15);
  EXPECT_EQ(share_of(Site(path, SiteAccess::kRead, {2}).map().result.map,
                     *Site(path, SiteAccess::kRead, {2}).edits()[0].on_map, SiteEditKind::kWall),
            1.0);
  Site(path, SiteAccess::kWrite, {2}).undo(2);
  expect_wall_on_tuesday(1, 0.15);
  Site(path, SiteAccess::kWrite, {2}).remove({1});
  expect_wall_on_tuesday(0, 0.15);
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

TEST_F(SiteOfAnOffice, WhatNothingTiesToOthersWaitsForSoManyAndThenGoes) {
  const TempDir folder;
  Site site(new_site(folder, "a"), SiteAccess::kWrite, {2});
  const auto added_on = [&](std::size_t which, int day) {
    MappedSession session = (*sessions_)[which];
    session.session.log += std::to_string(day);
    session.session.digest += std::to_string(day);
    session.session.begins = Stamp::from_seconds((20'000.0 + day) * kDayS);
    return site.add(session);
  };
  const auto first = added_on(3, 1);
  for (int day = 2; day <= kSite.keep_pending; ++day) (void)added_on(1, day);
  EXPECT_EQ(site.sessions().front().status, SessionStatus::kPending);
  EXPECT_EQ(added_on(1, kSite.keep_pending + 1).status, SessionStatus::kJoined);
  const SiteSession waited = site.sessions().front();
  EXPECT_EQ(waited.id, first.id);
  EXPECT_EQ(waited.status, SessionStatus::kRetired);
  EXPECT_THAT(waited.reason, HasSubstr("compared with 30 newer ones"));
  EXPECT_TRUE(site.file().check().empty());
  // One that is older than so many is compared with them all, and told of all the same.
  EXPECT_EQ(added_on(3, 0).status, SessionStatus::kRetired);
  EXPECT_EQ(site.sessions().front().status, SessionStatus::kRetired);
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
