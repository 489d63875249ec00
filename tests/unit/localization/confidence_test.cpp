#include "localization/confidence.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "localization/confidence_weights.hpp"

namespace loopstone {
namespace {

/// A pose of which nothing is wrong.
PoseEvidence perfect() {
  return {.explained = 1.0,
          .mass = 1.0,
          .precision = 1.0,
          .spread_m = 0.03,
          .spread_rad = 0.01,
          .innovation = 0.2,
          .followed_m = 10.0};
}

struct Piece {
  std::string name;
  double PoseEvidence::*value;
  double most;
  bool speaks_for;  ///< the more the better
};

const std::vector<Piece>& pieces() {
  static const std::vector<Piece> all{{"explained", &PoseEvidence::explained, 1.0, true},
                                      {"violations", &PoseEvidence::violations, 1.0, false},
                                      {"unexpected", &PoseEvidence::unexpected, 1.0, false},
                                      {"mass", &PoseEvidence::mass, 1.0, true},
                                      {"precision", &PoseEvidence::precision, 1.0, true},
                                      {"spread_m", &PoseEvidence::spread_m, 3.0, false},
                                      {"spread_rad", &PoseEvidence::spread_rad, 3.0, false},
                                      {"innovation", &PoseEvidence::innovation, 50.0, false},
                                      {"followed_m", &PoseEvidence::followed_m, 50.0, true}};
  return all;
}

double drawn_up_to(double most) { return most * *rc::gen::inRange(0, 1001) / 1000.0; }

PoseEvidence drawn_evidence() {
  PoseEvidence evidence;
  for (const Piece& piece : pieces()) evidence.*piece.value = drawn_up_to(piece.most);
  return evidence;
}

TEST(Confidence, WeightsAreFiniteAndNoneIsAnOrderOfMagnitudeOff) {
  for (const double weight : kConfidenceWeights) {
    EXPECT_TRUE(std::isfinite(weight));
    EXPECT_LT(std::abs(weight), 100.0);
  }
}

RC_GTEST_PROP(Confidence, FeaturesAreSharesAndTheFirstIsOne, ()) {
  const auto features = confidence_features(drawn_evidence());
  RC_ASSERT(features.front() == 1.0);
  for (const double feature : features) RC_ASSERT(feature >= 0.0 && feature <= 1.0);
}

RC_GTEST_PROP(Confidence, IsAProbabilityAndNeverMoreThanTheBeliefInThePlaceAllows, ()) {
  const PoseEvidence evidence = drawn_evidence();
  const double probability = pose_probability(evidence);
  RC_ASSERT(probability >= 0.0);
  RC_ASSERT(probability <= evidence.mass * evidence.precision);
}

RC_GTEST_PROP(Confidence, MoreEvidenceForAPoseNeverLowersIt, ()) {
  for (const Piece& piece : pieces()) {
    PoseEvidence less = drawn_evidence();
    PoseEvidence more = less;
    more.*piece.value = less.*piece.value + drawn_up_to(piece.most - less.*piece.value);
    if (!piece.speaks_for) std::swap(less, more);
    if (!(pose_probability(more) >= pose_probability(less))) RC_FAIL(piece.name);
  }
}

TEST(Confidence, WhatTellsRightFromWrongCounts) {
  for (const Piece& piece : pieces()) {
    if (piece.name != "explained" && piece.name != "violations" && piece.name != "mass" &&
        piece.name != "precision") {
      continue;
    }
    PoseEvidence worse = perfect();
    worse.*piece.value = 0.5 * piece.most;
    EXPECT_LT(pose_probability(worse), pose_probability(perfect()) - 1e-3) << piece.name;
  }
}

TEST(Confidence, APerfectPoseIsTrackedAndOneThatExplainsNothingIsLost) {
  EXPECT_GE(pose_probability(perfect()), 0.95);
  PoseEvidence wrong = perfect();
  wrong.explained = 0.15;
  wrong.violations = 0.4;
  wrong.unexpected = 0.3;
  wrong.innovation = 10.0;
  wrong.followed_m = 0.0;
  EXPECT_LT(pose_probability(wrong), 0.1);
}

TEST(Confidence, OneOfTwoPlacesThatLookAlikeIsNeverTracked) {
  PoseEvidence evidence = perfect();
  evidence.mass = 0.5;
  EXPECT_LE(pose_probability(evidence), 0.5);
}

TEST(Confidence, APlaceWithNewFurnitureIsNotLost) {
  PoseEvidence evidence = perfect();
  evidence.explained = 0.5;
  evidence.violations = 0.08;
  evidence.unexpected = 0.4;
  EXPECT_GE(pose_probability(evidence), 0.1);
}

TEST(Confidence, EndlessSpreadAndInnovationStayFinite) {
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  PoseEvidence evidence = perfect();
  evidence.spread_m = kEndless;
  evidence.spread_rad = kEndless;
  evidence.innovation = kEndless;
  evidence.followed_m = kEndless;
  EXPECT_TRUE(std::isfinite(pose_probability(evidence)));
  EXPECT_EQ(pose_probability(PoseEvidence{}), 0.0);
}

}  // namespace
}  // namespace loopstone
