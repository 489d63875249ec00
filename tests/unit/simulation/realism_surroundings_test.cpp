// People, things that move, panes, and worlds that are bent and turned.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "simulation/beam_path.hpp"
#include "simulation/company.hpp"
#include "simulation/moved_things.hpp"
#include "simulation/standers.hpp"
#include "support/simulated_log.hpp"

namespace loopstone {
namespace {

using test::noise_free;
using test::simulate_log;

constexpr double kNever = std::numeric_limits<double>::infinity();

Realism with(const std::string& effects) {
  Realism realism;
  choose_realism(realism, effects);
  return realism;
}

/// 20 m straight on at 1 m/s, then it stands.
Drive straight_drive() {
  Drive drive(Pose2{});
  for (int i = 0; i < 1000; ++i) drive.append(1.0, 0.0);
  for (int i = 0; i < 500; ++i) drive.append(0.0, 0.0);
  return drive;
}

Eigen::Vector2d middle_of(const std::vector<Circle>& legs, std::size_t person) {
  return 0.5 * (legs.at(2 * person).centre + legs.at(2 * person + 1).centre);
}

TEST(RealismCompany, AFollowerKeepsBehindAlongTheWay) {
  Realism realism = with("follower");
  realism.follower.from_s = 5.0;
  realism.follower.to_s = 15.0;
  const Drive drive = straight_drive();
  const SurfaceIndex nothing{FloorPlan{}};
  const Company company(drive, nothing, realism, 1);
  for (double time = 0.0; time < 20.0; time += 0.37) {
    std::vector<Circle> legs;
    company.add_legs(time, legs);
    if (time < 5.0 || time >= 15.0) {
      EXPECT_TRUE(legs.empty()) << time;
      continue;
    }
    ASSERT_EQ(legs.size(), 2U);
    const Eigen::Vector2d at = drive.pose_at(time).inverse() * middle_of(legs, 0);
    EXPECT_NEAR(at.x(), -0.4, 0.05);
    EXPECT_NEAR(at.y(), 0.65, 0.13);
  }
  RealismRecord record;
  company.note(record);
  ASSERT_EQ(record.spoils.size(), 1U);
  EXPECT_EQ(record.spoils[0].from_s, 5.0);
  EXPECT_EQ(record.spoils[0].to_s, 15.0);
}

TEST(RealismCompany, OneWalksAheadAndACrowdStandsAround) {
  Realism realism = with("ahead,crowd");
  realism.ahead.from_s = 0.0;
  realism.crowd = {
      .on = true, .from_s = 0.0, .to_s = 0.0, .count = 6, .radius_m = 1.0, .body_m = 0.0};
  const Drive drive = straight_drive();
  const SurfaceIndex nothing{FloorPlan{}};
  const Company company(drive, nothing, realism, 1);
  for (double time = 0.0; time < 29.0; time += 0.71) {
    std::vector<Circle> legs;
    company.add_legs(time, legs);
    ASSERT_EQ(legs.size(), 14U);
    const Pose2 robot = drive.pose_at(time);
    EXPECT_NEAR((robot.inverse() * middle_of(legs, 0)).x(), 1.2, 0.05);
    for (std::size_t person = 1; person < 7; ++person) {
      const double distance = (middle_of(legs, person) - robot.translation()).norm();
      EXPECT_GE(distance, 0.44);
      EXPECT_LE(distance, 1.36);
    }
  }
}

TEST(RealismCompany, AFollowerFallsInBehindWhereWallsLeaveNoRoom) {
  FloorPlan door;
  door.surfaces = {{{-50.0, 0.5}, {50.0, 0.5}}, {{-50.0, -0.5}, {50.0, -0.5}}};
  const SurfaceIndex walls(door);
  const Realism realism = with("follower");
  const Drive drive = straight_drive();
  const Company company(drive, walls, realism, 1);
  std::vector<Circle> legs;
  company.add_legs(10.0, legs);
  ASSERT_EQ(legs.size(), 2U);
  const Eigen::Vector2d at = drive.pose_at(10.0).inverse() * middle_of(legs, 0);
  EXPECT_LE(at.y(), 0.4);
  EXPECT_GE(at.norm(), 0.44);
}

TEST(RealismCompany, ABodyIsOneCircle) {
  Realism realism = with("crowd");
  realism.crowd.from_s = 0.0;
  const Drive drive = straight_drive();
  const SurfaceIndex nothing{FloorPlan{}};
  std::vector<Circle> bodies;
  Company(drive, nothing, realism, 1).add_legs(1.0, bodies);
  ASSERT_EQ(bodies.size(), static_cast<std::size_t>(realism.crowd.count));
  for (const Circle& body : bodies) EXPECT_EQ(body.radius_m, realism.crowd.body_m);
}

TEST(RealismCompany, NobodyStandsInTheRobotOrBehindAWall) {
  // It goes there and back: who followed is in its way.
  Drive drive(Pose2{});
  for (int i = 0; i < 200; ++i) drive.append(1.0, 0.0);
  for (int i = 0; i < 157; ++i) drive.append(0.0, 1.0);
  for (int i = 0; i < 200; ++i) drive.append(1.0, 0.0);
  FloorPlan plan;
  plan.surfaces = {{{-50.0, 0.9}, {50.0, 0.9}}, {{-50.0, -0.9}, {50.0, -0.9}}};
  const SurfaceIndex walls(plan);
  Realism realism = with("follower,ahead,crowd");
  realism.crowd.from_s = 0.0;
  realism.crowd.to_s = 0.0;
  realism.crowd.body_m = 0.0;
  const Company company(drive, walls, realism, 3);
  for (double time = 0.0; time < drive.duration_s(); time += 0.1) {
    std::vector<Circle> legs;
    company.add_legs(time, legs);
    const Eigen::Vector2d robot = drive.pose_at(time).translation();
    for (std::size_t person = 0; person < legs.size() / 2; ++person) {
      EXPECT_GE((middle_of(legs, person) - robot).norm(), 0.449);
      EXPECT_LT(std::abs(middle_of(legs, person).y()), 0.9);
    }
  }
}

TEST(RealismCompany, TheLaserSeesThem) {
  SimulationOptions options = noise_free({.duration_s = 20.0});
  options.laser.beams = 181;
  const auto alone = simulate_log("office", 1, options).scans();
  for (const std::string effect : {"follower", "ahead", "crowd", "walkers", "standers"}) {
    options.realism = with(effect);
    options.realism.crowd.from_s = 0.0;
    const auto scans = simulate_log("office", 1, options).scans();
    ASSERT_EQ(scans.size(), alone.size());
    std::size_t hidden = 0;
    for (std::size_t i = 0; i < scans.size(); ++i) {
      for (std::size_t beam = 0; beam < scans[i].ranges_m.size(); ++beam) {
        if (!std::isfinite(scans[i].ranges_m[beam])) continue;
        ASSERT_LE(scans[i].ranges_m[beam], alone[i].ranges_m[beam]) << effect;
        hidden += scans[i].ranges_m[beam] < alone[i].ranges_m[beam] ? 1 : 0;
      }
    }
    EXPECT_GT(hidden, 20U) << effect;
  }
}

TEST(RealismStanders, StandBesideTheWay) {
  const World world = make_world("office", 1);
  const Drive drive = drive_route(world, 0.25);
  const SurfaceIndex surfaces(world.plan);
  const Standers standers(drive, surfaces, {.on = true, .count = 12}, Rng(1));
  EXPECT_GE(standers.count(), 4U);
  std::size_t seen = 0;
  for (double time = 0.0; time < drive.duration_s(); time += 1.0) {
    std::vector<Circle> legs;
    standers.add_legs(time, legs);
    seen += legs.size();
    for (const Circle& leg : legs) {
      EXPECT_GT((leg.centre - drive.pose_at(time).translation()).norm(), 0.35);
    }
  }
  EXPECT_GT(seen, 0U);
}

TEST(RealismMoved, WallsStayAndNothingStandsInTheWay) {
  const World world = make_world("office", 1);
  const Drive drive = drive_route(world, 0.25);
  const MovedThings moved(world, drive, 0.25, {.on = true, .every_s = 30.0}, Rng(4));
  EXPECT_GT(moved.moved(), 20U);
  const SurfaceIndex drawn(world.plan);
  double least = 1.0;
  std::size_t differ = 0;
  for (double time = 0.0; time < drive.duration_s(); time += 0.5) {
    const SurfaceIndex& now = moved.surfaces_at(time);
    const Eigen::Vector2d robot = drive.pose_at(time).translation();
    least = std::min(least, now.distance(robot, 0.5));
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector2d direction(std::cos(0.8 * i), std::sin(0.8 * i));
      const double range = now.cast(robot, direction, 30.0);
      differ += range != drawn.cast(robot, direction, 30.0) ? 1 : 0;
      if (time < 30.0) {
        EXPECT_EQ(range, drawn.cast(robot, direction, 30.0));
      }
    }
  }
  EXPECT_GE(least, 0.25);
  EXPECT_GT(differ, 50U);
}

TEST(RealismGlass, ReturnsOnlyWhatMeetsItSquarely) {
  FloorPlan plan;
  plan.boxes.push_back({{5.0, 0.0, 0.0}, 0.1, 40.0, true});   // all glass
  plan.boxes.push_back({{9.0, 0.0, 0.0}, 0.1, 90.0, false});  // what stands behind it
  const SurfaceIndex surfaces(plan);
  Realism realism = with("glass");
  realism.glass.share = 1.0;
  const auto range_at = [&](double angle, const Realism& options) {
    return BeamPath(plan, options, 1)
        .follow(surfaces, {0.0, 0.0}, {std::cos(angle), std::sin(angle)}, 30.0, {})
        .range_m;
  };
  EXPECT_NEAR(range_at(0.0, realism), 4.95, 1e-9);
  EXPECT_NEAR(range_at(0.15, realism), 4.95 / std::cos(0.15), 1e-9);
  EXPECT_NEAR(range_at(0.6, realism), 8.95 / std::cos(0.6), 1e-9);
  EXPECT_NEAR(range_at(0.6, Realism{}), 4.95 / std::cos(0.6), 1e-9);
}

TEST(RealismMirrors, ShowTheRoomASecondTime) {
  FloorPlan plan;
  plan.boxes.push_back({{5.0, 0.0, 0.0}, 0.1, 40.0, true});    // the mirror
  plan.boxes.push_back({{-3.0, 0.0, 0.0}, 0.2, 40.0, false});  // behind the laser
  const SurfaceIndex surfaces(plan);
  Realism realism = with("mirrors");
  realism.mirrors.share = 1.0;
  const BeamPath path(plan, realism, 1);
  for (const double angle : {0.0, 0.3, -0.5}) {
    const BeamEcho met =
        path.follow(surfaces, {0.0, 0.0}, {std::cos(angle), std::sin(angle)}, 50.0, {});
    EXPECT_NEAR(met.range_m, (4.95 + 4.95 + 2.9) / std::cos(angle), 1e-4);
  }
  EXPECT_EQ(path.follow(surfaces, {0.0, 0.0}, {1.0, 0.0}, 8.0, {}).range_m, kNever);
}

TEST(RealWorld, TurnedIsTheSameWorldByAnyAngle) {
  RealismRecord record;
  const World drawn = make_world("office", 2);
  const World turned = real_world(drawn, with("turned"), 2, record);
  ASSERT_EQ(record.facts.size(), 1U);
  const double yaw = record.facts[0].value;
  EXPECT_GT(std::abs(yaw), 0.02);
  const Pose2 turn{0.0, 0.0, yaw};
  const SurfaceIndex before(drawn.plan);
  const SurfaceIndex after(turned.plan);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d from = drawn.places[static_cast<std::size_t>(i) % drawn.places.size()];
    const Eigen::Vector2d direction(std::cos(0.7 * i), std::sin(0.7 * i));
    const double range = before.cast(from, direction, 30.0);
    EXPECT_NEAR(after.cast(turn * from, turn * direction, 30.0), range, 1e-6);
  }
  RealismRecord other;
  (void)real_world(drawn, with("turned"), 3, other);
  EXPECT_NE(other.facts[0].value, yaw);
}

TEST(RealWorld, BentWallsAreNotStraightAndHold) {
  RealismRecord record;
  const World drawn = make_world("office", 2);
  const World bent = real_world(drawn, with("bent"), 2, record);
  EXPECT_GT(bent.plan.boxes.size(), 2 * drawn.plan.boxes.size());
  const Drive drive = drive_route(bent, 0.25);
  EXPECT_LT((drive.last_pose().translation() - bent.returns.back()).norm(), 0.5) << "a way is shut";
  // No ray leaves the building.
  const SurfaceIndex index(bent.plan);
  for (double time = 0.0; time < drive.duration_s(); time += 5.0) {
    for (int i = 0; i < 90; ++i) {
      const double angle = radians(4.0 * i);
      const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
      EXPECT_LT(index.cast(drive.pose_at(time).translation(), direction, 200.0), 100.0);
    }
  }
  double shifted = 0.0;
  for (std::size_t i = 0; i < drawn.places.size(); ++i)
    shifted = std::max(shifted, (drawn.places[i] - bent.places[i]).norm());
  EXPECT_GT(shifted, 0.1);
  EXPECT_LT(shifted, 0.5);
}

TEST(RealWorld, NothingOnIsTheWorldItself) {
  RealismRecord record;
  const World drawn = make_world("rooms", 2);
  const World same = real_world(drawn, Realism{}, 2, record);
  EXPECT_TRUE(record.facts.empty());
  ASSERT_EQ(same.plan.boxes.size(), drawn.plan.boxes.size());
  for (std::size_t i = 0; i < drawn.plan.boxes.size(); ++i)
    EXPECT_EQ(same.plan.boxes[i].map_T_box, drawn.plan.boxes[i].map_T_box);
}

}  // namespace
}  // namespace loopstone
