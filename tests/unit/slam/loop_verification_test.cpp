#include "slam/loop_verification.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "loop_scene.hpp"
#include "slam/loop_coverage.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

std::optional<VerifiedClosure> verified(const FinishedSubmap& older, const FinishedSubmap& newer,
                                        const LoopCandidate& candidate,
                                        const LoopOptions& options = {}) {
  return verify(candidate, older.submap, newer.submap, options, {}, {});
}

LoopCandidate near(const Pose2& older_T_newer) {
  LoopCandidate candidate{.older = {0}, .newer = {1}, .older_T_newer = older_T_newer};
  candidate.half_xy_m = 0.4;
  candidate.half_yaw_rad = 0.1;
  return candidate;
}

TEST(LoopVerification, ARoomIsRecognisedFromTheCorridorBesideIt) {
  const auto [room, corridor, room_T_corridor] = test::both_sides_of_a_thin_wall();
  LoopCandidate candidate = near(room_T_corridor);
  const LoopOptions lax{.min_score = 0.1, .min_overlap = 0.1};
  const auto found = verified(room, corridor, candidate, lax);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->closure.reason, ClosureReason::kWaitsForSecond);
  const Pose2 off = room_T_corridor.inverse() * found->closure.from_T_to;
  EXPECT_LT(off.translation().norm(), 0.05);
  EXPECT_LT(share_of(found->seen), 0.7 * found->closure.overlap) << "of its wall the other side";
  candidate.by_appearance = true;
  EXPECT_FALSE(verified(room, corridor, candidate, lax)) << "no pose vouches for it";
}

/// A room, and one of the same size in which things stand.
struct TwoRooms {
  FinishedSubmap full;
  FinishedSubmap bare;
};
TwoRooms rooms_that_are_alike() {
  const test::Walls bare = test::rectangle({0.0, 0.0}, {8.0, 6.0});
  test::Walls full = bare;
  for (const double x : {1.5, 3.5, 5.5})
    for (const double y : {1.5, 3.7})
      full = test::together({full, test::rectangle({x, y}, {x + 0.8, y + 0.8})});
  const std::vector<Pose2> poses{{1.0, 3.0, 0.0}, {4.0, 3.0, 0.0}, {7.0, 3.0, 3.0}};
  return {test::submap_seen_from(full, poses, 0), test::submap_seen_from(bare, poses, 0)};
}

TEST(LoopVerification, BehindABreakThingsThatWereSeenThereBeforeMustBeSeenAgain) {
  const auto [full, bare] = rooms_that_are_alike();
  LoopCandidate candidate = near({});
  const auto led_there = verified(full, bare, candidate);
  ASSERT_TRUE(led_there);
  EXPECT_EQ(led_there->closure.state, ClosureState::kWaiting) << "the path led there";
  candidate.across_break = true;
  const auto guessed = verified(full, bare, candidate);
  ASSERT_TRUE(guessed);
  EXPECT_EQ(guessed->closure.reason, ClosureReason::kSurfacesDisagree);
  EXPECT_LT(guessed->closure.agreement, led_there->closure.agreement);
}

}  // namespace
}  // namespace loopstone
