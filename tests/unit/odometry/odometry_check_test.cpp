#include "loopstone/odometry/odometry_check.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

constexpr double kInterval = 0.1;

Stamp stamp_at(int scan) { return Stamp::from_seconds(100.0 + kInterval * scan); }

/// A robot that drives, stops, and turns left and right by about a quarter: its motions from scan
/// to scan.
std::vector<Pose2> motions(int count, std::uint64_t seed) {
  Rng rng(seed);
  std::vector<Pose2> result;
  double speed = 0.0;
  double rate = 0.0;
  int left = 0;
  while (static_cast<int>(result.size()) < count) {
    if (left-- == 0) {
      const double kind = rng.uniform();
      speed = kind < 0.6 ? rng.uniform(0.3, 0.8) : 0.0;
      rate = kind >= 0.5 && kind < 0.9 ? rng.uniform(-1.0, 1.0) : 0.0;
      left = 10 + static_cast<int>(rng.below(30));
    }
    result.push_back(exp(Tangent2(speed * kInterval, 0.0, rate * kInterval)));
  }
  return result;
}

using Wheels = std::function<Pose2(const std::vector<Pose2>&, std::size_t)>;

/// What the laser and these wheels say of a drive; the laser errs by 3 mm and 2 mrad.
OdometryCheck check_drive(const std::vector<Pose2>& truth, const Wheels& wheels,
                          std::uint64_t seed = 1, bool sees_translation = true) {
  Rng rng(seed);
  OdometryCheck check;
  Pose2 error_before;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Pose2 error{rng.normal(0.0, 0.003), rng.normal(0.0, 0.003), rng.normal(0.0, 0.002)};
    const int scan = static_cast<int>(i);
    check.add({.from = stamp_at(scan),
               .to = stamp_at(scan + 1),
               .odometry = wheels(truth, i),
               .laser = error_before.inverse() * truth[i] * error,
               .sees_translation = sees_translation});
    error_before = error;
  }
  return check;
}

Wheels scaled(double translation, double rotation) {
  return [=](const std::vector<Pose2>& truth, std::size_t i) {
    return Pose2{translation * truth[i].x, translation * truth[i].y, rotation * truth[i].yaw};
  };
}

TEST(OdometryCheck, WheelsThatAreBadButHonestAreNeverAccused) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Rng rng(seed);
    const double scale = rng.uniform(0.95, 1.05);
    const double turn_scale = rng.uniform(0.88, 1.12);
    const OdometryCheck check =
        check_drive(motions(1500, seed), [&](const std::vector<Pose2>& truth, std::size_t i) {
          const double slip = rng.normal(0.0, 0.1);
          return Pose2{scale * (1.0 + slip) * truth[i].x, truth[i].y + rng.normal(0.0, 0.003),
                       turn_scale * truth[i].yaw + rng.normal(0.0, 0.004)};
        });
    EXPECT_TRUE(check.episodes().empty())
        << "seed " << seed << ": " << to_string(check.episodes().front().fault);
    EXPECT_EQ(check.translation().jumps() + check.rotation().jumps(), 0) << "seed " << seed;
    ASSERT_TRUE(check.translation().scale().has_value());
    EXPECT_NEAR(*check.translation().scale(), scale, 0.02) << "seed " << seed;
  }
}

struct FaultCase {
  std::string name;
  Wheels wheels;
  OdometryFault of_translation;
  OdometryFault of_rotation;
  double ratio_of_translation;
  double ratio_of_rotation;
};

class OdometryCheckOf : public testing::TestWithParam<FaultCase> {};

TEST_P(OdometryCheckOf, BothPartsAreNamedAfterAFewMetres) {
  const FaultCase& fault = GetParam();
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const OdometryCheck check = check_drive(motions(1000, seed), fault.wheels, seed);
    EXPECT_FALSE(check.trusts_translation());
    EXPECT_FALSE(check.trusts_rotation());
    ASSERT_EQ(check.episodes().size(), 2u) << "seed " << seed;
    for (const OdometryEpisode& episode : check.episodes()) {
      const bool turns = episode.part == OdometryPart::kRotation;
      EXPECT_EQ(episode.fault, turns ? fault.of_rotation : fault.of_translation)
          << to_string(episode.part) << " is " << to_string(episode.fault);
      EXPECT_NEAR(episode.ratio, turns ? fault.ratio_of_rotation : fault.ratio_of_translation, 0.1);
      EXPECT_FALSE(episode.over);
      EXPECT_LT((episode.noticed - stamp_at(0)).seconds(), 60.0) << "seed " << seed;
      EXPECT_EQ(episode.to, stamp_at(1000));
    }
    EXPECT_EQ(check.translation().jumps() + check.rotation().jumps(), 0);
    EXPECT_GT(check.distrusted_s(), 60.0);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Faults, OdometryCheckOf,
    testing::Values(FaultCase{"Stuck", scaled(0.0, 0.0), OdometryFault::kStuck,
                              OdometryFault::kStuck, 0.0, 0.0},
                    FaultCase{"Mirrored", scaled(-1.0, -1.0), OdometryFault::kMirrored,
                              OdometryFault::kMirrored, -1.0, -1.0},
                    FaultCase{"TooLarge", scaled(1.7, 1.7), OdometryFault::kScaled,
                              OdometryFault::kScaled, 1.7, 1.7},
                    FaultCase{"TooSmall", scaled(0.5, 0.4), OdometryFault::kScaled,
                              OdometryFault::kScaled, 0.5, 0.4}),
    [](const auto& named) { return named.param.name; });

TEST(OdometryCheck, WheelsThatSpinWhileTheRobotStands) {
  const std::vector<Pose2> standing(300, Pose2{});
  const OdometryCheck check = check_drive(standing, [](const std::vector<Pose2>&, std::size_t) {
    return Pose2{0.04, 0.0, 0.0};
  });
  ASSERT_EQ(check.episodes().size(), 1u);
  EXPECT_EQ(check.episodes().front().fault, OdometryFault::kSpinning);
  EXPECT_TRUE(check.trusts_rotation());
}

TEST(OdometryCheck, PartsAreJudgedApart) {
  const OdometryCheck check = check_drive(motions(1000, 3), scaled(1.0, -1.0));
  EXPECT_TRUE(check.trusts_translation());
  EXPECT_FALSE(check.trusts_rotation());
  ASSERT_EQ(check.episodes().size(), 1u);
  EXPECT_EQ(check.episodes().front().fault, OdometryFault::kMirrored);
}

TEST(OdometryCheck, WhatTheLaserCannotSeeIsNotHeldAgainstOdometry) {
  const OdometryCheck check = check_drive(motions(1000, 4), scaled(0.0, 1.0), 1, false);
  EXPECT_TRUE(check.trusts_translation());
  EXPECT_FALSE(check.translation().scale().has_value());
}

TEST(OdometryCheck, IsTrustedAgainWhenItHasBecomeRight) {
  const OdometryCheck check =
      check_drive(motions(2000, 5), [](const std::vector<Pose2>& truth, std::size_t i) {
        return i >= 300 && i < 800 ? Pose2{} : truth[i];
      });
  EXPECT_TRUE(check.trusts_translation());
  EXPECT_TRUE(check.trusts_rotation());
  for (const OdometryEpisode& episode : check.episodes()) {
    EXPECT_TRUE(episode.over);
    EXPECT_GE(episode.from, stamp_at(250));
    EXPECT_GE(episode.to, stamp_at(800));
    EXPECT_LT(episode.to, stamp_at(1500));
  }
  EXPECT_EQ(check.episodes().size(), 2u);
}

TEST(OdometryCheck, WhatAnotherDriveToldOfTheScaleCountsFromTheBeginning) {
  OdometryCheck check;
  EXPECT_FALSE(check.translation().scale());
  check.assume_scale(1.03);
  EXPECT_NEAR(check.translation().scale().value(), 1.03, 1e-12);
  // A drive that tells another one wins in the end.
  for (int scan = 0; scan < 40000; ++scan) {
    check.add({.from = stamp_at(scan),
               .to = stamp_at(scan + 1),
               .odometry = Pose2{0.05 * 1.01, 0.0, 0.0},
               .laser = Pose2{0.05, 0.0, 0.0},
               .sees_translation = true,
               .sees_rotation = true,
               .odometry_has_translation = true});
  }
  EXPECT_NEAR(check.translation().scale().value(), 1.01, 0.002);
}

TEST(OdometryCheck, JumpsAreCountedAndNothingElse) {
  const OdometryCheck check =
      check_drive(motions(1000, 6), [](const std::vector<Pose2>& truth, std::size_t i) {
        return i % 100 == 50 ? truth[i] * Pose2{0.8, 0.0, 0.0} : truth[i];
      });
  EXPECT_TRUE(check.episodes().empty());
  EXPECT_EQ(check.translation().jumps(), 10);
  EXPECT_EQ(check.rotation().jumps(), 0);
}

/// Wheels that say what was so many scans ago (or will be).
Wheels late_by(int scans) {
  return [=](const std::vector<Pose2>& truth, std::size_t i) {
    const auto at = static_cast<std::int64_t>(i) - scans;
    return at >= 0 && at < static_cast<std::int64_t>(truth.size())
               ? truth[static_cast<std::size_t>(at)]
               : Pose2{};
  };
}

TEST(OdometryCheck, LagIsFoundAndMeasured) {
  for (const int scans : {-3, 2, 4, 6}) {
    const OdometryCheck check = check_drive(motions(1000, 7), late_by(scans));
    EXPECT_FALSE(check.trusts_translation());
    ASSERT_FALSE(check.episodes().empty()) << scans;
    const OdometryEpisode& episode = check.episodes().back();
    EXPECT_EQ(episode.fault, OdometryFault::kLagging);
    EXPECT_NEAR(episode.lag_s, scans * kInterval, 0.051);
  }
}

TEST(OdometryCheck, SteadyMotionTellsNothingOfLag) {
  const std::vector<Pose2> steady(600, exp(Tangent2(0.05, 0.0, 0.02)));
  const OdometryCheck check = check_drive(steady, scaled(1.1, 0.95));
  EXPECT_TRUE(check.episodes().empty());
}

TEST(OdometryCheck, LagThatEndsIsForgivenOnceTheRobotHasShownIt) {
  const auto late = late_by(4);
  const OdometryCheck check =
      check_drive(motions(2500, 8), [&](const std::vector<Pose2>& truth, std::size_t i) {
        return i < 800 ? late(truth, i) : truth[i];
      });
  EXPECT_TRUE(check.trusts_translation());
  EXPECT_TRUE(check.trusts_rotation());
}

TEST(OdometryCheck, AGapInTheRecordingIsNoLag) {
  auto truth = motions(600, 9);
  truth[300] = Pose2{0.6, 0.0, 1.2};  // what happened meanwhile; wheels missed it
  const OdometryCheck check = check_drive(truth, [](const std::vector<Pose2>& all, std::size_t i) {
    return i == 300 ? Pose2{} : all[i];
  });
  EXPECT_TRUE(check.episodes().empty());
}

TEST(OdometryCheck, ALaserThatLooksAsideShowsWhileTheRobotGoesStraight) {
  for (const double yaw : {0.0, 0.09, -0.09}) {
    const auto turned = [&](const std::vector<Pose2>& truth, std::size_t i) {
      return Pose2{0.0, 0.0, -yaw} * truth[i] * Pose2{0.0, 0.0, yaw};
    };
    const auto offset = check_drive(motions(3000, 7), turned).laser_heading_offset_rad();
    ASSERT_TRUE(offset);
    EXPECT_NEAR(*offset, yaw, 0.01);
  }
  EXPECT_FALSE(check_drive(motions(50, 7), scaled(1.0, 1.0)).laser_heading_offset_rad());
}

}  // namespace
}  // namespace loopstone
