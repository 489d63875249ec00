#include "localization/state_judge.hpp"

#include <gtest/gtest.h>

namespace loopstone {
namespace {

constexpr auto kTracking = LocalizationState::kTracking;
constexpr auto kDoubtful = LocalizationState::kDoubtful;
constexpr auto kLost = LocalizationState::kLost;

/// One that has been TRACKING for a metre.
StateJudge sure() {
  StateJudge judge(0.9, 0.1);
  for (int i = 0; i < 20; ++i) (void)judge.judge(0.98, 0.98, 0.05);
  return judge;
}

TEST(StateJudge, IsTrackingWhereTheProbabilityWasHighForSomeWay) {
  StateJudge judge(0.9, 0.1);
  EXPECT_EQ(judge.judge(0.95, 0.95, 0.05), kDoubtful);
  EXPECT_EQ(judge.judge(0.95, 0.95, 0.05), kDoubtful);
  EXPECT_EQ(judge.judge(0.95, 0.95, 0.05), kTracking);
}

TEST(StateJudge, AVeryHighProbabilityNeedsNoWay) {
  StateJudge judge(0.9, 0.1);
  EXPECT_EQ(judge.judge(0.995, 0.995, 0.0), kTracking);
}

TEST(StateJudge, StandingAloneDoesNotMakeSure) {
  StateJudge judge(0.9, 0.1);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(judge.judge(0.95, 0.95, 0.0), kDoubtful);
}

TEST(StateJudge, AScanOrTwoThatFitBadlyChangeNothing) {
  StateJudge judge = sure();
  EXPECT_EQ(judge.judge(0.4, 0.4, 0.05), kTracking);
  EXPECT_EQ(judge.judge(0.4, 0.4, 0.05), kTracking);
  EXPECT_EQ(judge.judge(0.8, 0.8, 0.05), kTracking);
  EXPECT_EQ(judge.judge(0.4, 0.4, 0.05), kTracking);
}

TEST(StateJudge, ALongWayOfDoubtEndsIt) {
  StateJudge judge = sure();
  LocalizationState state = kTracking;
  double way_m = 0.0;
  while (state == kTracking && way_m < 1.0) {
    state = judge.judge(0.4, 0.4, 0.05);
    way_m += 0.05;
  }
  EXPECT_EQ(state, kDoubtful);
  EXPECT_LT(way_m, 0.35);
  EXPECT_EQ(judge.judge(0.95, 0.95, 0.05), kDoubtful) << "and is not forgotten at once";
}

TEST(StateJudge, ALongWayOfWorseScansEndsItHoweverProbableTheyAre) {
  StateJudge judge = sure();
  for (int i = 0; i < 10; ++i) EXPECT_EQ(judge.judge(0.98, 0.98, 0.05, true), kTracking);
  EXPECT_EQ(judge.judge(0.98, 0.98, 0.05, true), kDoubtful);
  EXPECT_EQ(judge.judge(0.98, 0.98, 0.05, true), kDoubtful);
  EXPECT_EQ(judge.judge(0.98, 0.98, 0.05, false), kTracking);
}

TEST(StateJudge, WhatIsBeyondDoubtEndsItAtOnce) {
  StateJudge judge = sure();
  EXPECT_EQ(judge.judge(0.02, 0.02, 0.05), kLost);
}

TEST(StateJudge, APoseThatIsImpreciseInTheRightPlaceIsDoubtfulAndNotLost) {
  StateJudge judge = sure();
  EXPECT_EQ(judge.judge(0.45, 0.95, 0.01), kDoubtful);
  EXPECT_EQ(judge.judge(0.01, 0.95, 0.01), kDoubtful);
}

TEST(StateJudge, AnotherPlaceBeginsAnew) {
  StateJudge judge = sure();
  judge.begin_anew();
  EXPECT_FALSE(judge.is_tracking());
  EXPECT_EQ(judge.judge(0.95, 0.95, 0.05), kDoubtful);
}

}  // namespace
}  // namespace loopstone
