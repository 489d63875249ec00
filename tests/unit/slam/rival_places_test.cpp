#include "slam/rival_places.hpp"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "loop_scene.hpp"
#include "slam/scan_edges.hpp"

namespace loopstone {
namespace {

const std::vector<Pose2> kVisit{
    {4.0, 3.0, 0.0}, {4.6, 3.2, 0.8}, {5.2, 3.8, 2.0}, {3.2, 2.5, -2.0}};
const std::vector<Pose2> kReturn{
    {3.4, 2.2, 1.7}, {3.3, 3.0, 2.6}, {2.6, 2.4, -1.0}, {4.6, 2.8, 0.2}};

bool find_rival(const LoopClosure& closure, const Eigen::Matrix3d& known,
                std::span<const SubmapRecord> submaps) {
  const AskedClosure asked{closure, known};
  return have_rival_places({&asked, 1}, {}, submaps, {}, {}, {}, {}).front();
}

/// A submap of a room as a visit of it shows it.
SubmapRecord visited(const test::Walls& room, const std::vector<Pose2>& visit,
                     const Pose2& map_T_room, std::size_t piece) {
  FinishedSubmap seen = test::submap_seen_from(room, visit, 0);
  seen.piece = piece;
  SubmapRecord record;
  record.freeze(std::move(seen));
  record.map_T_submap = map_T_room * visit.front();
  return record;
}

/// Rooms that are alike, side by side along x, and after a break a visit of the first one.
struct Rooms {
  std::vector<SubmapRecord> submaps{};
  LoopClosure closure{};

  explicit Rooms(int rooms) {
    for (int room = 0; room < rooms; ++room)
      submaps.push_back(visited(test::furnished_room(), kVisit, {9.0 * room, 0.0, 0.0}, 0));
    submaps.push_back(visited(test::furnished_room(), kReturn, {}, 1));
    closure.from_submap = {0};
    closure.to_submap = {submaps.size() - 1};
    closure.from_T_to = kVisit.front().inverse() * kReturn.front();
    closure.score = 0.8;
    closure.agreement = 0.95;
  }
  [[nodiscard]] bool has_rival(double sigma_m) const {
    return find_rival(closure, planar_covariance(sigma_m, 0.2), submaps);
  }
};

TEST(RivalPlaces, ARoomThatIsThereOnceHasNoRival) { EXPECT_FALSE(Rooms(1).has_rival(4.0)); }

TEST(RivalPlaces, AlikeRoomsAreRivalsAsFarAsThePathMayBeOff) {
  const Rooms rooms(2);
  EXPECT_TRUE(rooms.has_rival(5.0));
  EXPECT_FALSE(rooms.has_rival(1.5)) << "nine metres are six standard deviations";
  EXPECT_FALSE(rooms.has_rival(0.2)) << "the path knows";
}

/// A second submap of each of two rooms shows that one of them is empty, and deeper.
TEST(RivalPlaces, APlaceThatOtherSubmapsTellApartIsNoRival) {
  const std::vector<Pose2> again{{3.4, 2.4, 0.5}, {4.4, 3.4, 1.5}, {2.8, 2.2, -1.0}};
  for (const bool differs : {false, true}) {
    Rooms rooms(2);
    for (const std::size_t room : {0, 1}) {
      test::Walls seen = test::furnished_room();
      if (differs && room == 1) seen = test::rectangle({0.0, 0.0}, {8.0, 6.5});
      rooms.submaps.insert(rooms.submaps.begin() + 2,
                           visited(seen, again, {9.0 * static_cast<double>(room), 0.0, 0.0}, 0));
    }
    rooms.closure.to_submap = {rooms.submaps.size() - 1};
    EXPECT_TRUE(rooms.has_rival(5.0)) << "a third one may lie on the other side";
    rooms.submaps.back().map_T_submap.x += 4.5;
    EXPECT_EQ(rooms.has_rival(5.0), !differs) << "the path leads between these two";
  }
}

/// Two pairs of rooms, one above the other: the first ones are alike, the second ones are not.
/// After a break first a room like the first ones is visited, then the one beside it.
struct PairsOfRooms {
  std::vector<SubmapRecord> submaps{};
  LoopClosure first{};
  LoopClosure elsewhere{};

  PairsOfRooms() {
    const test::Walls bare = test::rectangle({0.0, 0.0}, {8.0, 6.5});
    const test::Walls full = test::furnished_room();
    submaps.push_back(visited(full, kVisit, {}, 0));
    submaps.push_back(visited(bare, kVisit, {9.0, 0.0, 0.0}, 0));
    submaps.push_back(visited(full, kVisit, {0.0, 8.0, 0.0}, 0));
    submaps.push_back(visited(test::rectangle({1.0, 1.0}, {7.0, 5.0}), kVisit, {9.0, 8.0, 0.0}, 0));
    // The path leads between the first ones, so that there is no third.
    submaps.push_back(visited(full, kReturn, {0.0, 4.0, 0.0}, 1));
    submaps.push_back(visited(bare, kReturn, {9.0, 4.0, 0.0}, 1));
    first = closure(0, 4);
    elsewhere = closure(2, 4);
  }
  [[nodiscard]] static LoopClosure closure(std::size_t from, std::size_t to) {
    LoopClosure closure;
    closure.from_submap = {from};
    closure.to_submap = {to};
    closure.from_T_to = kVisit.front().inverse() * kReturn.front();
    closure.score = 0.8;
    closure.agreement = 0.95;
    closure.state = ClosureState::kWaiting;
    return closure;
  }
};

TEST(RivalPlaces, WhatIsVisitedNextTellsPlacesApart) {
  PairsOfRooms rooms;
  const Eigen::Matrix3d known = planar_covariance(4.0, 0.2);
  EXPECT_FALSE(find_rival(rooms.first, known, rooms.submaps));
  EXPECT_TRUE(find_rival(rooms.elsewhere, known, rooms.submaps))
      << "the room beside it is another one";
  rooms.submaps.pop_back();
  EXPECT_TRUE(find_rival(rooms.first, known, rooms.submaps)) << "not visited yet";
}

TEST(RivalPlaces, ClosuresThatLayAllInOnePlaceStandOrFallTogether) {
  const PairsOfRooms rooms;
  const Eigen::Matrix3d known = planar_covariance(4.0, 0.2);
  // Nothing else is like the room beside the first one; but that one is asked about, too.
  const std::vector<AskedClosure> asked{
      {rooms.elsewhere, known}, {PairsOfRooms::closure(1, 5), known}, {rooms.first, known}};
  const std::vector<bool> expected{true, false, false};
  EXPECT_EQ(have_rival_places(asked, {}, rooms.submaps, {}, {}, {}, {}), expected);
}

/// Rooms of a building are alike, and one that is a little like them lies where nobody was.
TEST(RivalPlaces, WhereAPlaceRepeatsItselfTheFoundOneMustAgreeAsUsual) {
  PairsOfRooms rooms;
  const Eigen::Matrix3d known = planar_covariance(4.0, 0.2);
  // More submaps of the first room, for what is usual.
  for (int i = 0; i < 3; ++i) rooms.submaps.insert(rooms.submaps.begin(), rooms.submaps.front());
  const auto is_ambiguous = [&](const test::Walls& room) {
    rooms.submaps[7] = visited(room, kReturn, {0.0, 4.0, 0.0}, 1);
    return find_rival(PairsOfRooms::closure(3, 7), known, rooms.submaps);
  };
  EXPECT_FALSE(is_ambiguous(test::furnished_room()));
  const test::Walls more =
      test::together({test::furnished_room(), test::rectangle({5.0, 0.8}, {6.8, 2.0}),
                      test::rectangle({0.6, 4.0}, {2.2, 5.2})});
  EXPECT_TRUE(is_ambiguous(more));
}

TEST(RivalPlaces, APlaceThatWasAmbiguousOnceIsRememberedAsARival) {
  PairsOfRooms rooms;
  const Eigen::Matrix3d known = planar_covariance(4.0, 0.2);
  rooms.submaps.pop_back();
  // What scores twice what can be had is not found anew.
  const auto has_rival = [&](std::span<const LoopClosure> others) -> bool {
    const AskedClosure asked{rooms.first, known};
    return have_rival_places({&asked, 1}, others, rooms.submaps, {.min_score = 2.0}, {}, {}, {})
        .front();
  };
  EXPECT_FALSE(has_rival({}));
  EXPECT_TRUE(has_rival({&rooms.elsewhere, 1}));
  EXPECT_FALSE(has_rival({&rooms.first, 1})) << "that is the same place";
  rooms.elsewhere.from_T_to.x += 3.0;
  EXPECT_FALSE(has_rival({&rooms.elsewhere, 1})) << "it does not fit there";
}

TEST(RivalPlaces, WhereTheHeadingIsOpenARoomMayBeItsOwnMirror) {
  // An empty room, longer than wide, looks the same from the other side.
  const std::vector<Pose2> visit{{2.0, 1.5, 0.0}, {4.0, 2.5, 1.5}, {6.0, 1.5, 3.0}};
  const test::Walls room = test::rectangle({0.0, 0.0}, {8.0, 4.0});
  std::vector<SubmapRecord> submaps;
  for (std::size_t piece = 0; piece < 2; ++piece) {
    submaps.push_back(visited(room, visit, {}, piece));
  }
  LoopClosure closure;
  closure.from_submap = {0};
  closure.to_submap = {1};
  closure.score = 0.8;
  closure.agreement = 0.95;
  const auto is_ambiguous = [&](double sigma_rad) {
    return find_rival(closure, planar_covariance(5.0, sigma_rad), submaps);
  };
  EXPECT_FALSE(is_ambiguous(0.1)) << "the path knows the heading";
  EXPECT_TRUE(is_ambiguous(1.8));
}

/// Nothing that was seen is like the room; the robot may face anywhere.
TEST(RivalPlaces, WhereTheHeadingIsOpenAPlaceMustAgreeAsUsualThoughNothingRepeats) {
  Rooms rooms(1);
  for (int i = 0; i < 3; ++i) rooms.submaps.insert(rooms.submaps.begin(), rooms.submaps.front());
  rooms.closure.from_submap = {3};
  rooms.closure.to_submap = {4};
  const auto is_ambiguous = [&](const test::Walls& room, double sigma_rad) {
    rooms.submaps[4] = visited(room, kReturn, {}, 1);
    return find_rival(rooms.closure, planar_covariance(1.5, sigma_rad), rooms.submaps);
  };
  const test::Walls more =
      test::together({test::furnished_room(), test::rectangle({5.0, 0.8}, {6.8, 2.0}),
                      test::rectangle({0.6, 4.0}, {2.2, 5.2})});
  EXPECT_FALSE(is_ambiguous(test::furnished_room(), 1.8));
  EXPECT_FALSE(is_ambiguous(more, 0.05)) << "things were moved";
  EXPECT_TRUE(is_ambiguous(more, 1.8));
}

TEST(RivalPlaces, WithinOnePieceOfThePathNobodyIsAsked) {
  Rooms rooms(2);
  rooms.submaps.back().piece = 0;
  EXPECT_FALSE(rooms.has_rival(5.0));
}

TEST(RivalPlaces, FarFromWhereThePathLeadsIsUnlikely) {
  Rooms rooms(1);
  const Eigen::Matrix3d known = planar_covariance(0.3, 0.02);
  EXPECT_TRUE(is_likely(rooms.closure, known, 20.0, rooms.submaps));
  rooms.submaps.back().map_T_submap.x += 2.0;
  EXPECT_TRUE(is_likely(rooms.closure, known, 20.0, rooms.submaps));
  rooms.closure.second_score = 0.75;
  EXPECT_FALSE(is_likely(rooms.closure, known, 20.0, rooms.submaps)) << "it fits elsewhere too";
  EXPECT_TRUE(is_likely(rooms.closure, known, 200.0, rooms.submaps)) << "after a longer way";
  rooms.closure.second_score.reset();
  rooms.submaps.back().map_T_submap.x += 5.0;
  EXPECT_FALSE(is_likely(rooms.closure, known, 20.0, rooms.submaps));
}

}  // namespace
}  // namespace loopstone
