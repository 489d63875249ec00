#include "localization/pose_evidence.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace loopstone {
namespace {

constexpr BeamFit kGood{.explained = 1.0, .known = 1.0};
constexpr BeamFit kBad{
    .explained = 0.2, .violations = 0.5, .unexpected = 0.3, .known = 0.6, .silent = 0.1};

TEST(FitAlongWay, BeginsWithTheFirstScan) {
  FitAlongWay fit(2.0);
  EXPECT_FALSE(fit.any());
  fit.add(kBad, 0.0);
  ASSERT_TRUE(fit.any());
  EXPECT_EQ(fit.mean(), (FitOverWay{0.2, 0.5, 0.3, 0.6, 0.1}));
}

TEST(FitAlongWay, DoesNotDependOnHowOftenTheWayIsLookedAt) {
  FitAlongWay often(2.0);
  FitAlongWay seldom(2.0);
  often.add(kGood, 0.0);
  seldom.add(kGood, 0.0);
  for (int i = 0; i < 100; ++i) often.add(kBad, 0.03);
  for (int i = 0; i < 10; ++i) seldom.add(kBad, 0.3);
  EXPECT_NEAR(often.mean().explained, seldom.mean().explained, 1e-12);
  EXPECT_NEAR(often.mean().explained, 0.2 + 0.8 * std::exp(-3.0 / 2.0), 1e-12);
  EXPECT_NEAR(often.mean().known, 0.6 + 0.4 * std::exp(-3.0 / 2.0), 1e-12);
}

TEST(FitAlongWay, ARobotThatStandsLearnsNothingNew) {
  FitAlongWay fit(2.0);
  fit.add(kGood, 0.0);
  for (int i = 0; i < 1000; ++i) fit.add(kBad, 0.0);
  EXPECT_EQ(fit.mean().explained, 1.0);
}

TEST(FitAlongWay, BlindScansConfirmNothing) {
  FitAlongWay fit(2.0);
  fit.add_blind_scan(1.0);
  EXPECT_FALSE(fit.any());
  fit.add(kGood, 0.0);
  for (int i = 0; i < 10; ++i) fit.add_blind_scan(0.2);
  EXPECT_NEAR(fit.mean().explained, std::exp(-1.0), 1e-12);
  EXPECT_EQ(fit.mean().violations, 0.0);
}

TEST(FitAlongWay, ForgetsWhenItIsReset) {
  FitAlongWay fit(2.0);
  fit.add(kGood, 0.0);
  fit.reset();
  EXPECT_FALSE(fit.any());
}

}  // namespace
}  // namespace loopstone
