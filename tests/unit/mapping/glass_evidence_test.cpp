#include "mapping/glass_evidence.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

/// Incidences of a robot that drives by.
std::vector<double> drive_by() {
  std::vector<double> incidences;
  for (double ahead_m = -3.0; ahead_m <= 3.0; ahead_m += 0.2)
    incidences.push_back(std::atan(std::abs(ahead_m) / 1.5));
  return incidences;
}

template <typename Returns>
std::vector<SurfaceLook> looks(Returns&& returns) {
  std::vector<SurfaceLook> all;
  for (const double incidence : drive_by()) all.push_back({incidence, returns(incidence)});
  return all;
}

double probability(const std::vector<SurfaceLook>& looks) {
  return glass_probability(glass_log_ratio(looks));
}

TEST(GlassEvidence, NothingSeenIsNothingLearnt) {
  EXPECT_NEAR(glass_log_ratio({}), 0.0, 1e-12);
  EXPECT_NEAR(probability({}), kGlassEvidence.of_walls, 1e-12);
}

TEST(GlassEvidence, WhatReturnsSquarelyAloneIsGlass) {
  EXPECT_GT(probability(looks([](double incidence) { return incidence < 0.2; })), 0.95);
}

TEST(GlassEvidence, WhatReturnsAlwaysOrNeverIsNone) {
  EXPECT_LT(probability(looks([](double) { return true; })), 0.01);
  EXPECT_LT(probability(looks([](double) { return false; })), 0.2);
}

TEST(GlassEvidence, WhatReturnsAtAnyAngleNowAndThenIsNone) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Rng rng(seed);
    EXPECT_LT(probability(looks([&](double) { return rng.uniform() < 0.5; })), 0.3) << seed;
  }
}

TEST(GlassEvidence, WhatStoodThereForAWhileIsNone) {
  // The same looks as at glass, at other angles.
  for (const double to : {0.3, 0.5, 0.8}) {
    int count = 0;
    const auto stood = looks([&](double) { return ++count < to * 30.0; });
    EXPECT_LT(probability(stood), 0.3) << to;
  }
}

TEST(GlassEvidence, TheMovedAreTheSameBackwardsAndGlassIsTheSameInAnyOrder) {
  std::vector<SurfaceLook> glass = looks([](double incidence) { return incidence < 0.3; });
  const double forwards = glass_log_ratio(glass);
  std::ranges::reverse(glass);
  EXPECT_NEAR(glass_log_ratio(glass), forwards, 1e-9);
  // All steep looks first: something may have gone then.
  std::ranges::stable_sort(glass, {}, &SurfaceLook::incidence_rad);
  EXPECT_LT(glass_log_ratio(glass), forwards - 1.0);
}

TEST(GlassEvidence, ThousandsOfLooksAreStillNumbers) {
  std::vector<SurfaceLook> many;
  for (int i = 0; i < 300; ++i) {
    const auto some = looks([](double incidence) { return incidence < 0.2; });
    many.insert(many.end(), some.begin(), some.end());
  }
  EXPECT_TRUE(std::isfinite(glass_log_ratio(many)));
  EXPECT_NEAR(probability(many), 1.0, 1e-6);
}

}  // namespace
}  // namespace loopstone
