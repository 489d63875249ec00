#include "loopstone/plan/extract_plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "loopstone/base/error.hpp"
#include "plan_scene.hpp"

namespace loopstone::test {
namespace {

/// Lengths of the walls, shortest first.
std::vector<double> wall_lengths(const VectorPlan& plan) {
  std::vector<double> lengths;
  for (const PlanSegment& segment : plan.segments)
    if (segment.layer == PlanLayer::kStructure) lengths.push_back(segment.length_m());
  std::sort(lengths.begin(), lengths.end());
  return lengths;
}

class ExtractPlanAtAnyYaw : public testing::TestWithParam<double> {};

TEST_P(ExtractPlanAtAnyYaw, ARectangleHasItsSize) {
  const VectorPlan plan = PlanScene({12.3, -4.5, GetParam()}).rectangle(5.2, 3.7).plan();
  ASSERT_EQ(plan.segments.size(), 4U);
  const std::vector<double> lengths = wall_lengths(plan);
  ASSERT_EQ(lengths.size(), 4U);
  const double sigma_m = std::sqrt(2.0) * plan.segments[0].sigma_across_m;
  EXPECT_LT(sigma_m, 0.006);
  EXPECT_NEAR(lengths[0], 3.7, 4.0 * sigma_m);
  EXPECT_NEAR(lengths[1], 3.7, 4.0 * sigma_m);
  EXPECT_NEAR(lengths[2], 5.2, 4.0 * sigma_m);
  EXPECT_NEAR(lengths[3], 5.2, 4.0 * sigma_m);
  ASSERT_EQ(plan.rooms.size(), 1U);
  const PlanRoom& room = plan.rooms[0];
  EXPECT_TRUE(room.is_closed());
  EXPECT_EQ(room.outline.polygon.corners.size(), 4U);
  EXPECT_NEAR(room.area_m2, 5.2 * 3.7, 4.0 * room.area_sigma_m2);
  EXPECT_LT(room.area_sigma_m2, 0.002 * room.area_m2);
  EXPECT_NEAR(room.area_m2, area_of(room.outline.polygon), 1e-9);
  EXPECT_NEAR(room.perimeter_m, 2.0 * (5.2 + 3.7), 0.03);
  EXPECT_TRUE(plan.doors.empty());
  ASSERT_EQ(plan.axes.size(), 1U);
  EXPECT_NEAR(std::remainder(plan.axes[0].yaw_rad - GetParam(), 0.5 * kPi), 0.0, 0.002);
}

TEST_P(ExtractPlanAtAnyYaw, TwoRoomsHaveADoorBetweenThem) {
  const VectorPlan plan = two_rooms({-3.0, 8.0, GetParam()}).plan();
  ASSERT_EQ(plan.rooms.size(), 2U);
  for (const PlanRoom& room : plan.rooms) {
    EXPECT_NEAR(room.area_m2, 12.0, 0.12);
    EXPECT_TRUE(room.is_closed());
    EXPECT_EQ(room.doors, std::vector<int>{0});
    EXPECT_EQ(std::count(room.outline.sides.begin(), room.outline.sides.end(), PlanSide::kDoor), 1);
  }
  ASSERT_EQ(plan.doors.size(), 1U);
  const PlanDoor& door = plan.doors[0];
  EXPECT_NEAR(door.width_m, 0.9, 0.02);
  EXPECT_NEAR(door.depth_m, 0.12, 0.02);
  EXPECT_FALSE(door.is_opening());
  EXPECT_NEAR((door.to - door.from).norm(), door.width_m, 0.01);
  EXPECT_EQ(std::min(door.room, door.other_room), 0);
  EXPECT_EQ(std::max(door.room, door.other_room), 1);
  const Eigen::Vector2d middle = Pose2{-3.0, 8.0, GetParam()} * Eigen::Vector2d(4.06, 1.45);
  EXPECT_LT((0.5 * (door.from + door.to) - middle).norm(), 0.02);
}

INSTANTIATE_TEST_SUITE_P(Yaws, ExtractPlanAtAnyYaw,
                         testing::Values(0.0, 0.1, 0.5, 0.25 * kPi, 1.2, -2.4));

TEST(ExtractPlan, SquaresOnlyWhatCannotBeToldFromSquare) {
  // The right wall leans by 3 deg; all others are square.
  const double lean = 3.7 * std::tan(radians(3.0));
  const VectorPlan plan =
      PlanScene().floor({{0.0, 0.0}, {5.2, 0.0}, {5.2 + lean, 3.7}, {0.0, 3.7}}).plan();
  ASSERT_EQ(plan.segments.size(), 4U);
  int squared = 0;
  for (const PlanSegment& segment : plan.segments) {
    const double yaw = std::atan2(segment.direction().y(), segment.direction().x());
    const double off = std::abs(std::remainder(yaw, 0.5 * kPi));
    if (segment.squared) {
      ++squared;
      EXPECT_LT(off, 0.002);
    } else {
      EXPECT_NEAR(degrees(off), 3.0, 0.2);
    }
  }
  EXPECT_EQ(squared, 3);
}

TEST(ExtractPlan, FreeSpaceIsOnTheLeftOfEverySegment) {
  const Grid<std::int8_t> cells = two_rooms().cells();
  for (const PlanSegment& segment : two_rooms().plan().segments) {
    // Not in the middle, where the wall between the rooms stands.
    const Eigen::Vector2d before =
        segment.from + 0.3 * (segment.to - segment.from) + 0.1 * segment.normal();
    EXPECT_EQ(cells[cells.frame().cell_of(before)], 0);
  }
}

TEST(ExtractPlan, ARoomThatEndsUnexploredSaysSo) {
  // The right side was not seen.
  const VectorPlan plan =
      PlanScene()
          .floor({{0.0, 0.0}, {5.0, 0.0}, {5.0, 4.0}, {0.0, 4.0}}, {true, false, true, true})
          .plan();
  ASSERT_EQ(plan.rooms.size(), 1U);
  EXPECT_FALSE(plan.rooms[0].is_closed());
  EXPECT_NEAR(plan.rooms[0].open_m, 4.0, 0.3);
  EXPECT_NEAR(plan.rooms[0].area_m2, 20.0, 0.6);
}

TEST(ExtractPlan, AThingInTheRoomIsNoWall) {
  PlanScene scene;
  scene.rectangle(6.0, 5.0);
  for (const auto& [from, to] :
       std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>>{{{3.4, 2.0}, {2.4, 2.0}},
                                                                {{2.4, 2.0}, {2.4, 2.6}},
                                                                {{2.4, 2.6}, {3.4, 2.6}},
                                                                {{3.4, 2.6}, {3.4, 2.0}}}) {
    scene.face(from, to);
  }
  const VectorPlan plan = scene.plan();
  EXPECT_NEAR(length_of(plan, PlanLayer::kStructure), 22.0, 0.1);
  EXPECT_NEAR(length_of(plan, PlanLayer::kMovable), 3.2, 0.2);
  ASSERT_EQ(plan.rooms.size(), 1U);
  EXPECT_NEAR(plan.rooms[0].area_m2, 30.0, 0.1);  // the floor under it is floor
  EXPECT_TRUE(plan.rooms[0].holes.empty());
}

TEST(ExtractPlan, CellsAloneAreGoodToACell) {
  for (const double yaw : {0.0, 0.3}) {
    const Grid<std::int8_t> cells = PlanScene({0.013, 0.021, yaw}).rectangle(5.2, 3.7).cells();
    const VectorPlan plan = extract_plan(cells, samples_of_cells(cells));
    EXPECT_FALSE(plan.from_scans);
    ASSERT_EQ(plan.rooms.size(), 1U);
    EXPECT_NEAR(plan.rooms[0].area_m2, 5.2 * 3.7, 3.0 * plan.rooms[0].area_sigma_m2);
    EXPECT_LT(plan.rooms[0].area_sigma_m2, 0.02 * plan.rooms[0].area_m2);
    for (const PlanSegment& segment : plan.segments) EXPECT_GE(segment.sigma_across_m, 0.014);
  }
}

TEST(ExtractPlan, AMapWithoutWallsIsRefused) {
  const Grid<std::int8_t> cells(GridFrame{.columns = 20, .rows = 20}, 0);
  EXPECT_TRUE(samples_of_cells(cells).samples.empty());
  EXPECT_THROW((void)extract_plan(cells, samples_of_cells(cells)), UsageError);
}

TEST(VectorPlan, IsTheSameInAnotherFrame) {
  const VectorPlan plan = two_rooms().plan();
  const Pose2 there{3.0, -2.0, 0.7};
  const VectorPlan moved = there * plan;
  const VectorPlan back = there.inverse() * moved;
  for (std::size_t i = 0; i < plan.segments.size(); ++i) {
    EXPECT_LT((back.segments[i].from - plan.segments[i].from).norm(), 1e-12);
    EXPECT_LT((moved.segments[i].to - there * plan.segments[i].to).norm(), 1e-12);
  }
  for (std::size_t i = 0; i < plan.rooms.size(); ++i) {
    EXPECT_NEAR(area_of(moved.rooms[i].outline.polygon), area_of(plan.rooms[i].outline.polygon),
                1e-9);
    EXPECT_TRUE(contains(moved.rooms[i].outline.polygon, label_place(moved.rooms[i])));
  }
  EXPECT_LT((moved.doors[0].from - there * plan.doors[0].from).norm(), 1e-12);
}

TEST(VectorPlan, StraightenedRunsAlongXAndY) {
  const VectorPlan plan = two_rooms({1.0, 2.0, 0.3}).plan();
  const VectorPlan straight = straight_T_map(plan) * plan;
  for (const PlanSegment& segment : straight.segments) {
    if (segment.length_m() < 1.0) continue;
    const Eigen::Vector2d u = segment.direction();
    EXPECT_LT(std::min(std::abs(u.x()), std::abs(u.y())), 0.003);
  }
  EXPECT_NEAR(box_of(straight).size().x(), 8.12, 0.02);
  EXPECT_NEAR(box_of(straight).size().y(), 3.0, 0.02);
}

}  // namespace
}  // namespace loopstone::test
