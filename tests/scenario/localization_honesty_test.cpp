// Where a robot can't know its place, it must say so: never TRACKING at a wrong pose.

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>

#include "localization_drives.hpp"

namespace loopstone::test {
namespace {

TEST(LocalizationHonesty, RoomsThatLookAlikeAreDoubtful) {
  const std::uint64_t seeds = small_scale() ? 1 : 3;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const Drive drive = make_run({.place = "rooms",
                                  .seed = seed,
                                  .duration_s = small_scale() ? 6.0 : 12.0,
                                  .beams = 361,
                                  .random_start = true});
    const LocalizationResult result = localize(drive);
    EXPECT_EQ(judge(result, drive).wrong_tracking, 0) << "seed " << seed;
    ASSERT_FALSE(result.estimates.empty());
    EXPECT_GT(result.estimates.front().hypotheses, 5) << "seed " << seed;
    EXPECT_NE(result.estimates.front().state, LocalizationState::kTracking) << "seed " << seed;
  }
}

TEST(LocalizationHonesty, TurnedByHalfATurnAWarehouseIsTheSameAndNeitherWayIsSure) {
  // Its two ends lie on the map's cells otherwise, by another part of a cell for each seed.
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Drive drive =
        make_run({.place = "aisles", .seed = seed, .duration_s = 10.0, .beams = 181});
    const Verdict verdict = judge(localize(drive), drive);
    EXPECT_GT(verdict.scans, 20);
    EXPECT_EQ(verdict.tracking, 0) << "seed " << seed;
  }
}

TEST(LocalizationHonesty, OneOfThePlacesThatAreFollowedIsTheTrueOne) {
  const Drive drive = make_run(
      {.place = "rooms", .seed = 3, .duration_s = 8.0, .beams = 361, .random_start = true});
  const LocalizationResult result = localize(drive);
  ASSERT_FALSE(result.snapshots.empty());
  for (const BeliefSnapshot& snapshot : result.snapshots) {
    const Pose2 truth = *drive.truth.at_clamped(snapshot.stamp);
    EXPECT_TRUE(std::any_of(snapshot.hypotheses.begin(), snapshot.hypotheses.end(),
                            [&](const LocalizationHypothesis& place) {
                              return std::hypot(place.map_T_robot.x - truth.x,
                                                place.map_T_robot.y - truth.y) < 0.5;
                            }))
        << snapshot.hypotheses.size() << " places, none of them the true one";
  }
}

TEST(LocalizationHonesty, ACorridorIsDoubtfulWhenItsLengthHasBecomeUnsure) {
  const Drive drive = make_run(
      {.place = "corridor", .seed = 1, .duration_s = small_scale() ? 60.0 : 110.0, .beams = 361});
  const LocalizationResult result = localize(drive, guess_of(drive));
  const Verdict verdict = judge(result, drive);
  EXPECT_EQ(verdict.wrong_tracking, 0);
  EXPECT_GT(verdict.tracking, 0) << "at its beginning the way is known";
  EXPECT_GT(verdict.doubtful, 0.3 * verdict.scans);
  EXPECT_GT(verdict.doubtful, verdict.lost);
}

TEST(LocalizationHonesty, AMapOfAnotherBuildingIsNotTrusted) {
  const Drive drive = make_run(
      {.place = "office", .seed = 1, .duration_s = small_scale() ? 3.0 : 6.0, .beams = 361});
  for (const char* building : {"rooms", "warehouse"}) {
    const LocalizationMap other(true_map(make_world(building, 1)));
    const LocalizationResult result = localize(other, drive);
    EXPECT_EQ(judge(result, drive).tracking, 0) << building;
    ASSERT_FALSE(result.estimates.empty()) << building;
    EXPECT_GT(result.estimates.back().evidence.unproven, 0.1) << "the map itself is doubted";
  }
  for (const LocalizationEstimate& estimate : localize(drive).estimates)
    EXPECT_EQ(estimate.evidence.unproven, 0.0);
}

TEST(LocalizationHonesty, AMapOfABuildingLikeItIsDoubtedOnTheWay) {
  // Offices of one kind have rooms of one kind: for a while, one may pass for another.
  const Drive drive = make_run({.place = "office", .seed = 1, .duration_s = 10.0, .beams = 361});
  const LocalizationMap other(true_map(make_world("office", 11)));
  const Verdict verdict = judge(localize(other, drive), drive);
  EXPECT_LT(verdict.tracking, 0.5 * verdict.scans);
}

TEST(LocalizationHonesty, AWrongGuessIsNotTrusted) {
  const std::uint64_t seeds = small_scale() ? 1 : 4;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const Drive drive =
        make_run({.place = "office", .seed = seed, .duration_s = 15.0, .beams = 361});
    const InitialPose wrong{drive.truth.front().pose * Pose2{3.0, 2.0, 1.0}, 0.3, 0.2};
    const Verdict verdict = judge(localize(drive, wrong), drive);
    EXPECT_EQ(verdict.wrong_tracking, 0) << "seed " << seed;
    EXPECT_TRUE(verdict.last_right) << "seed " << seed;
  }
}

TEST(LocalizationHonesty, WithoutOdometryItWarnsAndIsNeverWronglySure) {
  const Drive drive =
      laser_alone(make_run({.place = "office", .seed = 2, .duration_s = 15.0, .beams = 361}));
  for (const auto& initial : {std::optional<InitialPose>{}, std::optional(guess_of(drive))}) {
    const LocalizationResult result = localize(drive, initial);
    EXPECT_FALSE(result.had_odometry);
    EXPECT_TRUE(std::any_of(result.warnings.begin(), result.warnings.end(), [](const auto& text) {
      return text.find("no odometry") != std::string::npos;
    }));
    EXPECT_EQ(judge(result, drive).wrong_tracking, 0);
  }
}

TEST(LocalizationHonesty, WithoutOdometryScansThatComeInABurstAreFollowed) {
  Drive drive =
      laser_alone(make_run({.place = "office", .seed = 2, .duration_s = 15.0, .beams = 361}));
  // Each fifth is stamped late: 2 ms before the next one.
  std::set<Stamp> late;
  for (std::size_t i = 4; i + 1 < drive.messages.size(); i += 5) {
    auto& scan = std::get<LaserScan>(drive.messages[i]);
    scan.stamp = std::get<LaserScan>(drive.messages[i + 1]).stamp - Duration{2'000'000};
    late.insert(scan.stamp);
  }
  for (const LocalizationEstimate& estimate : localize(drive, guess_of(drive)).estimates) {
    if (late.contains(estimate.stamp)) continue;
    EXPECT_TRUE(error_of(estimate, drive).right()) << estimate.travelled_m << " m on its way";
  }
}

TEST(LocalizationHonesty, ScansThatShowNothingAreNoPose) {
  const Drive drive = make_run({.place = "office", .seed = 1, .duration_s = 4.0, .beams = 181});
  const auto all_nan = [](LaserScan& scan) {
    std::fill(scan.ranges_m.begin(), scan.ranges_m.end(), std::numeric_limits<float>::quiet_NaN());
  };
  const auto all_far = [](LaserScan& scan) {
    std::fill(scan.ranges_m.begin(), scan.ranges_m.end(), std::numeric_limits<float>::infinity());
  };
  const auto no_beams = [](LaserScan& scan) { scan.ranges_m.clear(); };
  for (const auto& change :
       std::vector<std::function<void(LaserScan&)>>{all_nan, all_far, no_beams}) {
    const Drive recorded = with_scans(drive, change);
    const LocalizationResult nowhere = localize(recorded);
    EXPECT_TRUE(nowhere.estimates.empty());
    EXPECT_EQ(nowhere.scans_dropped, nowhere.scans);
    EXPECT_FALSE(nowhere.warnings.empty());
    const LocalizationResult guessed = localize(recorded, guess_of(drive));
    EXPECT_EQ(judge(guessed, recorded).tracking, 0);
  }
}

TEST(LocalizationHonesty, AScannerThatGoesBlindIsNoLongerTrusted) {
  Drive drive = make_run({.place = "office", .seed = 2, .duration_s = 30.0, .beams = 361});
  const Stamp blind = drive.truth.front().stamp + Duration::from_seconds(8.0);
  drive = with_scans(std::move(drive), [&](LaserScan& scan) {
    if (scan.stamp >= blind) {
      std::fill(scan.ranges_m.begin(), scan.ranges_m.end(),
                std::numeric_limits<float>::quiet_NaN());
    }
  });
  const LocalizationResult result = localize(drive, guess_of(drive));
  const Verdict verdict = judge(result, drive);
  EXPECT_GT(verdict.tracking, 0);
  EXPECT_GT(result.scans_dropped, 100);
  EXPECT_NE(result.estimates.back().state, LocalizationState::kTracking);
  EXPECT_EQ(verdict.wrong_tracking, 0);
}

TEST(LocalizationHonesty, NoScansAreNoResult) {
  Drive drive = make_run({.place = "office", .seed = 1, .duration_s = 1.0, .beams = 61});
  drive.messages.clear();
  const LocalizationResult result = localize(drive);
  EXPECT_EQ(result.scans, 0);
  EXPECT_TRUE(result.estimates.empty());
}

}  // namespace
}  // namespace loopstone::test
