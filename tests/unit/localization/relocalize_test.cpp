#include "loopstone/localization/relocalize.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "drawn_room.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/pose_distance.hpp"
#include "loopstone/simulation/simulate.hpp"
#include "support/pose_near.hpp"
#include "support/simulated_log.hpp"

namespace loopstone {
namespace {

using test::drawn;
using test::furnished_room;
using test::pose_near;
using test::scan_from;
using test::Walls;
using testing::HasSubstr;

const Eigen::Vector2d kLow{0.0, 0.0};
const Eigen::Vector2d kHigh{8.0, 6.0};
const Pose2 kMount{0.2, 0.05, 0.1};

/// Two rectangular rooms, alike: of each scan there are four places, as a rectangle looks the same
/// when it is turned by half.
Walls two_rooms() {
  return test::together({test::rectangle({0.025, 0.025}, {3.525, 4.525}),
                         test::rectangle({4.025, 0.025}, {7.525, 4.525})});
}

double total(const Relocalization& found) {
  return std::accumulate(
      found.candidates.begin(), found.candidates.end(), found.none_probability,
      [](double sum, const PlaceCandidate& candidate) { return sum + candidate.probability; });
}

bool is_listed(const Relocalization& found, const Pose2& pose) {
  return std::ranges::any_of(found.candidates, [&](const PlaceCandidate& candidate) {
    return is_within(candidate.map_T_robot, pose, 0.05, 0.02);
  });
}

TEST(Relocalize, FindsTheOnlyPlaceAndIsSureOfIt) {
  const Walls room = furnished_room();
  const LocalizationMap map(drawn(room, kLow, kHigh));
  for (const Pose2& truth : {Pose2{3.0, 3.0, 0.3}, Pose2{6.5, 4.5, -2.0}, Pose2{1.5, 1.0, 1.4}}) {
    const Relocalization found = relocalize(map, scan_from(room, truth, kMount, {}), kMount);
    ASSERT_FALSE(found.candidates.empty());
    const PlaceCandidate& best = found.candidates.front();
    EXPECT_TRUE(pose_near(best.map_T_robot, truth, 0.05, 0.02));
    EXPECT_GT(best.probability, 0.9);
    EXPECT_GT(best.fit.explained, 0.95);
    EXPECT_LT(best.fit.violations, 0.05);
    EXPECT_GT(best.covariance.determinant(), 0.0);
    EXPECT_LT(std::sqrt(best.covariance(0, 0)), 0.05);
    EXPECT_LT(found.none_probability, 0.1);
    EXPECT_LE(total(found), 1.0 + 1e-9);
    EXPECT_TRUE(found.complete);
  }
}

/// The naive twin: every pose of a lattice over the map, by the share of returns near a wall. The
/// best of each place.
std::vector<Pose2> exhaustive(const Walls& walls, const LaserScan& scan, double least_share) {
  std::vector<Eigen::Vector2d> points;
  for (std::size_t beam = 0; beam < scan.ranges_m.size(); beam += scan.ranges_m.size() / 30) {
    const auto range = static_cast<double>(scan.ranges_m[beam]);
    if (!std::isfinite(range)) continue;
    const double angle = scan.angle_rad(beam);
    points.emplace_back(kMount * Eigen::Vector2d(range * std::cos(angle), range * std::sin(angle)));
  }
  struct Scored {
    Pose2 pose;
    double share;
  };
  std::vector<Scored> all;
  for (double x = 0.1; x < kHigh.x(); x += 0.1) {
    for (double y = 0.1; y < kHigh.y(); y += 0.1) {
      for (double yaw = -kPi; yaw < kPi; yaw += 0.05) {
        const Pose2 pose{x, y, yaw};
        const auto on_wall = std::ranges::count_if(points, [&](const Eigen::Vector2d& point) {
          return test::distance_to_walls(walls, pose * point) < 0.15;
        });
        const double share = static_cast<double>(on_wall) / static_cast<double>(points.size());
        if (share >= least_share) all.push_back({pose, share});
      }
    }
  }
  std::ranges::stable_sort(all, std::ranges::greater{}, &Scored::share);
  std::vector<Pose2> places;
  for (const Scored& scored : all) {
    const bool known = std::ranges::any_of(
        places, [&](const Pose2& place) { return is_within(place, scored.pose, 0.8, 0.5); });
    if (!known) places.push_back(scored.pose);
  }
  return places;
}

TEST(Relocalize, ListsThePlacesThatAnExhaustiveSearchFinds) {
  const Walls rooms = two_rooms();
  const LocalizationMap map(drawn(rooms, kLow, kHigh));
  const LaserScan scan = scan_from(rooms, {1.4, 1.2, 0.4}, kMount, {});
  const Relocalization found = relocalize(map, scan, kMount);
  const std::vector<Pose2> places = exhaustive(rooms, scan, 0.97);
  ASSERT_EQ(places.size(), 4U);
  for (const Pose2& place : places) {
    EXPECT_TRUE(std::ranges::any_of(found.candidates,
                                    [&](const PlaceCandidate& candidate) {
                                      return is_within(candidate.map_T_robot, place, 0.15, 0.06);
                                    }))
        << place.x << " " << place.y << " " << place.yaw;
  }
}

TEST(Relocalize, PlacesThatAreEqualShareTheBelief) {
  const Walls rooms = two_rooms();
  const LocalizationMap map(drawn(rooms, kLow, kHigh));
  const Pose2 truth{1.4, 1.2, 0.4};
  const Relocalization found = relocalize(map, scan_from(rooms, truth, kMount, {}), kMount);
  ASSERT_GE(found.candidates.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_GT(found.candidates[i].probability, 0.15) << i;
    EXPECT_LT(found.candidates[i].probability, 0.35) << i;
  }
  EXPECT_TRUE(is_listed(found, truth));
  EXPECT_TRUE(is_listed(found, Pose2{4.0, 0.0, 0.0} * truth));
  EXPECT_LT(found.none_probability, 0.15);
  EXPECT_LE(total(found), 1.0 + 1e-9);
}

TEST(Relocalize, RoomsThatLookAlikeAreNoCertainty) {
  const test::SimulatedLog log = test::simulate_log("rooms", 2, {.duration_s = 3.0});
  const LocalizationMap map(true_map(log.world));
  const LaserScan scan = log.scans().front();
  const Pose2 truth = *log.truth.at_clamped(scan.stamp);
  const Relocalization found = relocalize(map, scan, mount_of(scan, log.robot));
  ASSERT_GE(found.candidates.size(), 2U);
  EXPECT_TRUE(is_listed(found, truth));
  const double best = found.candidates[0].probability;
  EXPECT_LT(best, 0.7);
  EXPECT_GT(found.candidates[1].probability, 0.3 * best);
  EXPECT_LT(found.none_probability, 0.5);
  EXPECT_LE(total(found), 1.0 + 1e-9);
}

TEST(Relocalize, OnTheMapOfAnotherPlaceItIsAtNoneMostProbably) {
  const LocalizationMap map(true_map(make_world("office", 7)));
  int doubted = 0;
  int asked = 0;
  const test::SimulatedLog log = test::simulate_log("warehouse", 1, {.duration_s = 20.0});
  const std::vector<LaserScan> scans = log.scans();
  for (std::size_t i = 0; i < scans.size(); i += scans.size() / 4) {
    const Relocalization found = relocalize(map, scans[i], mount_of(scans[i], log.robot));
    ++asked;
    if (found.none_probability > 0.8) ++doubted;
    EXPECT_LE(total(found), 1.0 + 1e-9);
  }
  EXPECT_GE(doubted, asked - 1);
}

TEST(Relocalize, ASecondViewDecidesBetweenPlacesThatAreAlikeInTheFirst) {
  // One room is longer than the other, which the first view does not show. Either looks the same
  // when it is turned by half.
  const Walls rooms = test::together({test::rectangle({0.025, 0.025}, {3.525, 4.525}),
                                      test::rectangle({4.025, 0.025}, {7.525, 5.525})});
  const LocalizationMap map(drawn(rooms, kLow, kHigh));
  const Pose2 truth{6.2, 2.0, -kPi / 2};
  LaserScan front = scan_from(rooms, truth, Pose2{}, {});
  const Pose2 turn{0.0, 0.0, kPi};
  LaserScan back = scan_from(rooms, truth * turn, Pose2{}, {});
  const auto half = [](LaserScan& scan) {
    for (std::size_t beam = 0; beam < scan.ranges_m.size(); ++beam) {
      if (std::abs(wrap_angle(scan.angle_rad(beam))) > 1.3)
        scan.ranges_m[beam] = std::numeric_limits<float>::quiet_NaN();
    }
  };
  half(front);
  half(back);
  const auto at_truth = [&](const Relocalization& found) {
    const auto place = std::ranges::find_if(found.candidates, [&](const PlaceCandidate& candidate) {
      return is_within(candidate.map_T_robot, truth, 0.05, 0.02);
    });
    return place == found.candidates.end() ? 0.0 : place->probability;
  };
  const TakenScan one{.scan = front};
  const std::vector<TakenScan> both{one, {.scan = back, .robot_T_then = turn}};
  const Relocalization by_one = relocalize(map, std::span(&one, 1));
  const Relocalization by_both = relocalize(map, both);
  EXPECT_LT(at_truth(by_one), 0.3);
  EXPECT_GT(at_truth(by_both), 0.4);
  // The same once more tells nothing.
  const std::vector<TakenScan> twice{one, one};
  EXPECT_EQ(at_truth(relocalize(map, twice)), at_truth(by_one));
}

TEST(Relocalize, SameBytesForAnyNumberOfThreads) {
  const Walls rooms = two_rooms();
  const LocalizationMap map(drawn(rooms, kLow, kHigh));
  const LaserScan scan = scan_from(rooms, {1.4, 1.2, 0.4}, kMount, {});
  const Relocalization one = relocalize(map, scan, kMount, {1});
  const Relocalization many = relocalize(map, scan, kMount, {5});
  ASSERT_EQ(one.candidates.size(), many.candidates.size());
  EXPECT_EQ(one.none_probability, many.none_probability);
  for (std::size_t i = 0; i < one.candidates.size(); ++i) {
    EXPECT_EQ(one.candidates[i].map_T_robot.vector(), many.candidates[i].map_T_robot.vector());
    EXPECT_EQ(one.candidates[i].covariance, many.candidates[i].covariance);
    EXPECT_EQ(one.candidates[i].probability, many.candidates[i].probability);
  }
}

std::string refusal_of(const LocalizationMap& map, const TakenScan& taken) {
  try {
    (void)relocalize(map, std::span(&taken, 1));
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(Relocalize, RefusesScansThatTellNothing) {
  const Walls room = furnished_room();
  const LocalizationMap map(drawn(room, kLow, kHigh));
  TakenScan taken{.scan = scan_from(room, {3.0, 3.0, 0.3}, kMount, {}), .robot_T_lidar = kMount};
  for (std::size_t beam = 3; beam < taken.scan.ranges_m.size(); ++beam)
    taken.scan.ranges_m[beam] = std::numeric_limits<float>::infinity();
  EXPECT_THAT(refusal_of(map, taken), HasSubstr("has 3 returns"));
  taken.scan.ranges_m.clear();
  EXPECT_THAT(refusal_of(map, taken), HasSubstr("has 0 returns"));
  taken.robot_T_lidar.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal_of(map, taken), HasSubstr("not finite"));
  EXPECT_THROW((void)relocalize(map, std::span<const TakenScan>()), UsageError);
  // A map on which nothing is free is refused before.
  EXPECT_THROW(LocalizationMap(Grid<std::int8_t>(map.occupancy().frame(), 100)), UsageError);
}

}  // namespace
}  // namespace loopstone
