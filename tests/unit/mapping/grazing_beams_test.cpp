#include "mapping/grazing_beams.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <vector>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

constexpr double kNearM = 0.05;

Beam beam_to(double x, double y, bool hit = true) { return {{0.0, 0.0}, {x, y}, hit}; }

/// How much of a beam's end is not free.
double held_back_m(const std::vector<Beam>& beams, std::size_t i) {
  return (beams[i].end - free_end(beams, i, kNearM)).norm();
}

/// Beams from the origin to a wall at y = distance, a degree apart.
std::vector<Beam> along_wall(double distance_m) {
  std::vector<Beam> beams;
  for (int degrees = 5; degrees <= 175; ++degrees)
    beams.push_back(beam_to(distance_m / std::tan(radians(degrees)), distance_m));
  return beams;
}

TEST(GrazingBeams, ABeamIsFreeUpToWhereItIsNearTheWallThatItGrazes) {
  const std::vector<Beam> beams = along_wall(1.2);
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const double sine = std::sin(radians(static_cast<double>(i) + 5.0));
    EXPECT_NEAR(held_back_m(beams, i), kNearM * (1.0 / sine - 1.0), 1e-9) << i;
    EXPECT_NEAR(1.2 - free_end(beams, i, kNearM).y(), kNearM * (1.0 - sine), 1e-9) << i;
  }
  EXPECT_NEAR(held_back_m(beams, 85), 0.0, 1e-12) << "straight ahead";
}

TEST(GrazingBeams, WhereSomethingStandsBeforeAWallNothingIsHeldBack) {
  // A post, seen by one beam, or by two; the wall is 3 m behind.
  const std::vector<Beam> post{beam_to(6.0, -0.06), beam_to(6.0, -0.03), beam_to(3.0, 0.0),
                               beam_to(6.0, 0.03), beam_to(6.0, 0.06)};
  EXPECT_LT(held_back_m(post, 2), 1e-4);
  const std::vector<Beam> edge{beam_to(3.0, -0.03), beam_to(3.0, 0.0), beam_to(6.0, 0.03),
                               beam_to(6.0, 0.06), beam_to(6.0, 0.09)};
  for (std::size_t i = 0; i < edge.size(); ++i) EXPECT_LT(held_back_m(edge, i), 1e-3) << i;
}

TEST(GrazingBeams, NeighboursWithoutAReturnTellNothing) {
  for (const std::size_t lost : {1U, 2U, 3U}) {
    std::vector<Beam> beams = along_wall(0.5);
    beams.resize(4);
    beams[lost].hit = false;
    const double held = held_back_m(beams, lost);
    EXPECT_EQ(held, 0.0) << lost;
  }
  const std::vector<Beam> two{beam_to(9.0, 0.4), beam_to(9.4, 0.4)};
  EXPECT_EQ(held_back_m(two, 0), 0.0);
}

RC_GTEST_PROP(GrazingBeams, WhatIsFreeLiesOnTheBeamAndIsFinite, ()) {
  std::vector<Beam> beams;
  const auto number = [] { return *rc::gen::inRange(-200, 201) / 10.0; };
  for (int i = 0; i < 8; ++i)
    beams.push_back(beam_to(number(), number(), *rc::gen::inRange(0, 3) > 0));
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const Eigen::Vector2d end = free_end(beams, i, kNearM);
    RC_ASSERT(end.allFinite());
    RC_ASSERT(end.norm() <= beams[i].end.norm() + 1e-12);
    RC_ASSERT(std::abs(end.x() * beams[i].end.y() - end.y() * beams[i].end.x()) < 1e-9);
  }
}

}  // namespace
}  // namespace loopstone
