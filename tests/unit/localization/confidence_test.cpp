#include "localization/confidence.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "localization/confidence_weights.hpp"

namespace loopstone {
namespace {

/// A pose of which nothing is wrong.
PoseEvidence perfect() {
  const FitOverWay all{.explained = 1.0, .known = 1.0};
  return {.explained = 1.0,
          .mass = 1.0,
          .precision = 1.0,
          .spread_m = 0.03,
          .spread_rad = 0.01,
          .innovation = 0.2,
          .followed_m = 10.0,
          .known = 1.0,
          .lately = all,
          .along = all};
}

struct Piece {
  std::string name;
  std::function<double&(PoseEvidence&)> value;
  double most;
  bool speaks_for;  ///< the more the better
};

/// All but what is unexpected, which is set apart from what is explained.
const std::vector<Piece>& pieces() {
  using E = PoseEvidence;
  static const std::vector<Piece> all{
      {"explained", [](E& e) -> double& { return e.explained; }, 1.0, true},
      {"violations", [](E& e) -> double& { return e.violations; }, 1.0, false},
      {"mass", [](E& e) -> double& { return e.mass; }, 1.0, true},
      {"precision", [](E& e) -> double& { return e.precision; }, 1.0, true},
      {"spread_m", [](E& e) -> double& { return e.spread_m; }, 3.0, false},
      {"spread_rad", [](E& e) -> double& { return e.spread_rad; }, 3.0, false},
      {"innovation", [](E& e) -> double& { return e.innovation; }, 50.0, false},
      {"followed_m", [](E& e) -> double& { return e.followed_m; }, 50.0, true},
      {"lately explained", [](E& e) -> double& { return e.lately.explained; }, 1.0, true},
      {"lately violations", [](E& e) -> double& { return e.lately.violations; }, 1.0, false},
      {"lately known", [](E& e) -> double& { return e.lately.known; }, 1.0, true},
      {"along explained", [](E& e) -> double& { return e.along.explained; }, 1.0, true},
      {"along violations", [](E& e) -> double& { return e.along.violations; }, 1.0, false},
      {"along known", [](E& e) -> double& { return e.along.known; }, 1.0, true},
      {"along silent", [](E& e) -> double& { return e.along.silent; }, 1.0, false},
      {"unproven", [](E& e) -> double& { return e.unproven; }, 1.0, false}};
  return all;
}

double drawn_up_to(double most) { return most * *rc::gen::inRange(0, 1001) / 1000.0; }

PoseEvidence drawn_evidence() {
  PoseEvidence evidence;
  for (const Piece& piece : pieces()) piece.value(evidence) = drawn_up_to(piece.most);
  for (double* unexpected :
       {&evidence.unexpected, &evidence.lately.unexpected, &evidence.along.unexpected})
    *unexpected = drawn_up_to(1.0);
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
    piece.value(more) = piece.value(less) + drawn_up_to(piece.most - piece.value(less));
    if (!piece.speaks_for) std::swap(less, more);
    if (!(pose_probability(more) >= pose_probability(less))) RC_FAIL(piece.name);
  }
}

RC_GTEST_PROP(Confidence, PeopleBeforeTheWallsNeverRaiseIt, ()) {
  // Whatever share of the rest is explained.
  const PoseEvidence drawn = drawn_evidence();
  const double fewer = drawn_up_to(0.6);
  const double more = fewer + drawn_up_to(0.6 - fewer);
  const auto with = [&](double unexpected) {
    PoseEvidence evidence = drawn;
    const auto set = [&](auto& fit, double of_rest) {
      fit.explained = of_rest * (1.0 - unexpected);
      fit.unexpected = unexpected;
    };
    set(evidence, drawn.explained);
    set(evidence.lately, drawn.lately.explained);
    set(evidence.along, drawn.along.explained);
    return pose_probability(evidence);
  };
  RC_ASSERT(with(more) <= with(fewer) + 1e-12);
}

TEST(Confidence, WhatTellsRightFromWrongCounts) {
  for (const Piece& piece : pieces()) {
    if (piece.name != "explained" && piece.name != "violations" && piece.name != "mass" &&
        piece.name != "precision") {
      continue;
    }
    PoseEvidence worse = perfect();
    piece.value(worse) = 0.5 * piece.most;
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
  wrong.lately =
      wrong.along = {.explained = 0.15, .violations = 0.4, .unexpected = 0.3, .known = 1.0};
  EXPECT_LT(pose_probability(wrong), 0.1);
}

TEST(Confidence, WhereAMapHasProvenWrongMuchMoreIsAskedOfAPlaceThatFits) {
  PoseEvidence evidence = perfect();
  evidence.explained = evidence.lately.explained = evidence.along.explained = 0.85;
  evidence.followed_m = 1.0;
  ASSERT_GE(pose_probability(evidence), 0.9);
  evidence.unproven = 1.0;
  EXPECT_LT(pose_probability(evidence), 0.5);
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
  evidence.lately =
      evidence.along = {.explained = 0.5, .violations = 0.08, .unexpected = 0.4, .known = 1.0};
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
