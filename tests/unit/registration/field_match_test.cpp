#include "loopstone/registration/field_match.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "loopstone/geometry/rigid_motion.hpp"
#include "map_scene.hpp"
#include "support/generators.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

struct Scene {
  World world = test::room_with_cabinet();
  SurfaceIndex surfaces{world.plan};
  Grid<std::int8_t> map = true_map(world, 0.05);
  MapField field{map};
};

const Scene& room() {
  static const Scene scene;
  return scene;
}

TEST(MapField, DistancesAreThoseToTheFacesOfWalls) {
  const MapField& field = room().field;
  // The faces lie somewhere within their cells.
  for (const double x : {0.1, 0.15, 0.2, 0.25}) {
    const FieldSample sample = field.sample(0, {x, 3.0});
    EXPECT_NEAR(sample.distance_m, x - 0.03, 0.026) << x;
    EXPECT_NEAR(sample.gradient.x(), 1.0, 1e-6) << x;
    EXPECT_NEAR(sample.gradient.y(), 0.0, 1e-6) << x;
  }
  EXPECT_EQ(field.sample(0, {4.5, 4.0}).distance_m, field.reach_m(0));
  EXPECT_EQ(field.sample(0, {-50.0, 4.0}).distance_m, field.reach_m(0));
}

TEST(MapField, InsidesOfWallsAreNotVisible) {
  Grid<std::int8_t> map(GridFrame{.resolution = 0.1, .columns = 12, .rows = 7}, 100);
  for (int column = 0; column < 12; ++column) map[{column, 6}] = 0;
  const auto walls = visible_walls(map, 65);
  EXPECT_EQ((walls[{4, 5}]), 1);
  EXPECT_EQ((walls[{4, 4}]), 0);
  EXPECT_EQ((walls[{4, 6}]), 0);
  const auto all = visible_walls(Grid<std::int8_t>(map.frame(), 100), 65);
  EXPECT_EQ((all[{4, 4}]), 1) << "a map without free cells shows walls alone";
}

RC_GTEST_PROP(MapFieldLaws, GradientsAreThoseOfTheInterpolation, ()) {
  const MapField& field = room().field;
  const auto level = static_cast<std::size_t>(*rc::gen::inRange(0, 3));
  const Eigen::Vector2d point(*test::between(0.2, 9.0), *test::between(0.2, 6.0));
  constexpr double kStep = 1e-7;
  const FieldSample at = field.sample(level, point);
  if (at.distance_m >= field.reach_m(level) - 1e-5) return;
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(axis);
    const double ahead = (field.sample(level, point + step).distance_m - at.distance_m) / kStep;
    const double behind = (at.distance_m - field.sample(level, point - step).distance_m) / kStep;
    // On the border between two cells' patches the two sides differ, and either will do.
    RC_ASSERT(std::min(std::abs(at.gradient(axis) - ahead), std::abs(at.gradient(axis) - behind)) <
              1e-5);
  }
}

RC_GTEST_PROP(FieldMatchLaws, AnalyticGradientIsTheNumericOne, ()) {
  Rng rng(*rc::gen::arbitrary<std::uint64_t>());
  const Pose2 truth = test::place_in(room().world, room().surfaces, {0.5, 0.5}, {9.0, 5.8}, rng);
  const auto scan = test::scan_at(room().surfaces, truth, rng);
  const Pose2 pose{truth.x + rng.uniform(-0.05, 0.05), truth.y + rng.uniform(-0.05, 0.05),
                   truth.yaw + rng.uniform(-0.02, 0.02)};
  const auto level = static_cast<std::size_t>(rng.below(3));
  const double width = rng.uniform(0.03, 0.2);
  constexpr double kStep = 1e-7;
  const FieldCost at = field_cost(scan, room().field, level, pose, width);
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(axis);
    const auto cost_at = [&](const Eigen::Vector3d& motion) {
      return field_cost(scan, room().field, level, RigidMotion<2>::moved(pose, motion), width).cost;
    };
    const double numeric = (cost_at(step) - cost_at(-step)) / (2.0 * kStep);
    // A point may cross from one cell to the next within the step, or out of reach.
    RC_ASSERT(std::abs(numeric - at.gradient(axis)) < 0.02 * (1.0 + at.gradient.norm()));
  }
}

TEST(FieldMatch, FindsThePoseFromNearbyWithAnHonestCovariance) {
  Rng rng(4);
  double normalised_sum = 0.0;
  constexpr int kTrials = 60;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Pose2 truth = test::place_in(room().world, room().surfaces, {0.5, 0.5}, {9.0, 5.8}, rng);
    const auto scan = test::scan_at(room().surfaces, truth, rng);
    const Pose2 guess{truth.x + rng.uniform(-0.1, 0.1), truth.y + rng.uniform(-0.1, 0.1),
                      truth.yaw + rng.uniform(-0.1, 0.1)};
    const MatchResult match = match_to_field(scan, room().field, guess);
    ASSERT_EQ(match.status, MatchStatus::kConverged) << trial;
    EXPECT_TRUE(test::pose_near(match.target_T_source, truth, 0.05, radians(0.5))) << trial;
    EXPECT_GT(match.score, 0.95);
    EXPECT_LT(match.rmse_m, 0.04);
    const Eigen::Vector3d error = RigidMotion<2>::difference(match.target_T_source, truth);
    normalised_sum += error.dot(match.covariance.inverse() * error);
  }
  // 3 when the covariance is that of the errors.
  EXPECT_GT(normalised_sum / kTrials, 0.5);
  EXPECT_LT(normalised_sum / kTrials, 8.0);
}

TEST(FieldMatch, TheOrderOfPointsDoesNotMatter) {
  Rng rng(5);
  const Pose2 truth{4.0, 4.0, 0.7};
  auto scan = test::scan_at(room().surfaces, truth, rng);
  const Pose2 guess{4.05, 3.93, 0.75};
  const MatchResult forward = match_to_field(scan, room().field, guess);
  std::reverse(scan.begin(), scan.end());
  const MatchResult backward = match_to_field(scan, room().field, guess);
  EXPECT_TRUE(test::pose_near(forward.target_T_source, backward.target_T_source, 1e-6, 1e-6));
}

TEST(FieldMatch, ACorridorLeavesItsAxisOpen) {
  World world;
  test::add_room(world.plan, 0.0, 0.0, 200.0, 2.0);
  world.map_T_start = {100.0, 1.0, 0.0};
  const MapField field(true_map(world, 0.05));
  const SurfaceIndex surfaces(world.plan);
  Rng rng(6);
  const auto scan = test::scan_at(surfaces, {100.0, 1.0, 0.1}, rng);
  const MatchResult match = match_to_field(scan, field, {100.3, 1.05, 0.12});
  EXPECT_EQ(match.status, MatchStatus::kDegenerate);
  EXPECT_NEAR(match.target_T_source.y, 1.0, 0.04);
  EXPECT_GT(match.covariance(0, 0), 1.0);
  EXPECT_LT(match.covariance(1, 1), 0.01);
}

/// A corridor of 40 m whose walls run across the rows of cells at an angle.
World slanted_corridor(double yaw) {
  World world;
  for (const double side : {-1.1, 1.1}) {
    const Pose2 wall = Pose2{20.0, 20.0, yaw} * Pose2{0.0, side, 0.0};
    world.plan.boxes.push_back({wall, 40.0, 0.2});
  }
  world.map_T_start = {20.0, 20.0, yaw};
  return world;
}

TEST(MapField, NormalsAreTheWallsNotTheirCells) {
  for (const double yaw : {0.0, 0.1, 0.3, 0.785, 1.2, 2.0}) {
    const MapField field(true_map(slanted_corridor(yaw), 0.05));
    double worst = 0.0;
    for (double along = -15.0; along < 15.0; along += 0.07) {
      const Pose2 before = Pose2{20.0, 20.0, yaw} * Pose2{along, 0.97, 0.0};
      const FieldSample sample = field.sample(0, before.translation());
      const Eigen::Vector2d normal = field.wall_normal(before.translation(), sample);
      EXPECT_NEAR(normal.norm(), 1.0, 1e-9);
      // It points away from the wall, as the gradient does: back to the corridor's middle.
      const Eigen::Vector2d expected = -before.rotation().col(1);
      worst = std::max(worst, std::acos(std::clamp(normal.dot(expected), -1.0, 1.0)));
    }
    EXPECT_LT(worst, 0.12) << yaw;
  }
}

TEST(FieldMatch, ASlantedCorridorLeavesItsAxisOpenToo) {
  for (const double yaw : {0.1, 0.3, 0.785, 1.2}) {
    const World world = slanted_corridor(yaw);
    const MapField field(true_map(world, 0.05));
    const SurfaceIndex surfaces(world.plan);
    Rng rng(6);
    const Pose2 truth{20.0, 20.0, yaw};
    // The far ends are out of the laser's reach.
    auto scan = test::scan_at(surfaces, truth, rng);
    std::erase_if(scan, [](const Eigen::Vector2d& point) { return point.norm() > 10.0; });
    const MatchResult match = match_to_field(scan, field, truth * Pose2{0.3, 0.05, 0.02});
    const Eigen::Vector2d along = truth.rotation().col(0);
    const Eigen::Vector2d across = truth.rotation().col(1);
    const Eigen::Matrix2d covariance = match.covariance.topLeftCorner<2, 2>();
    EXPECT_EQ(match.status, MatchStatus::kDegenerate) << yaw;
    EXPECT_GT(along.dot(covariance * along), 1.0) << yaw;
    EXPECT_LT(across.dot(covariance * across), 0.01) << yaw;
  }
}

TEST(FieldMatch, WallsThatContradictEachOtherMakeItLessSure) {
  // A room drawn 8 cm wider than it is: either wall or both are off.
  World wide = room().world;
  World narrow = room().world;
  wide.plan.boxes[3].map_T_box.x += 0.08;
  const MapField field(true_map(wide, 0.05));
  const SurfaceIndex surfaces(narrow.plan);
  Rng rng(3);
  const Pose2 truth{4.5, 4.0, 0.3};
  const auto scan = test::scan_at(surfaces, truth, rng);
  const MatchResult right = match_to_field(scan, room().field, truth);
  const MatchResult doubtful = match_to_field(scan, field, truth);
  EXPECT_GT(doubtful.covariance(0, 0), 1.5 * right.covariance(0, 0));
}

TEST(FieldMatch, FarFromEverythingThePoseIsTheGuess) {
  Rng rng(7);
  const auto scan = test::scan_at(room().surfaces, {4.0, 4.0, 0.0}, rng);
  const Pose2 guess{400.0, 0.0, 1.0};
  const MatchResult match = match_to_field(scan, room().field, guess);
  EXPECT_EQ(match.status, MatchStatus::kTooFewPairs);
  EXPECT_EQ(match.target_T_source, guess);
  EXPECT_EQ(match_to_field({}, room().field, guess).status, MatchStatus::kTooFewPairs);
}

}  // namespace
}  // namespace loopstone
