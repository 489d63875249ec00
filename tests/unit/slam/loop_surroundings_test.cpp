#include "slam/loop_surroundings.hpp"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "loop_scene.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

constexpr double kHarmlessM = 0.25;

/// Surfaces of one bin of directions.
void put(SurfaceWitness& witness, std::size_t bin, double seen, double matched) {
  witness.seen[bin] = seen;
  witness.matched[bin] = matched;
}

TEST(LoopSurroundings, SurfacesFaceAlongADirectionToWithin60Degrees) {
  SurfaceWitness witness;
  put(witness, 0, 5.0, 4.0);  // along x
  put(witness, 6, 7.0, 6.0);  // along y
  EXPECT_EQ(facing(witness.seen, {1.0, 0.0}), 5.0);
  EXPECT_EQ(facing(witness.seen, {0.0, -3.0}), 7.0);
  EXPECT_EQ(facing(witness.matched, {1.0, 1.0}), 10.0);
}

TEST(LoopSurroundings, WallsAlongACorridorHoldNoWayAlongIt) {
  SurfaceWitness witness;
  put(witness, 6, 1000.0, 950.0);  // its walls
  put(witness, 0, 100.0, 20.0);    // frames of doors
  EXPECT_FALSE(hold(witness, {8.0, 0.0}, kHarmlessM));
  EXPECT_TRUE(hold(witness, {0.1, 0.0}, kHarmlessM)) << "as good as none";
  put(witness, 0, 100.0, 90.0);
  EXPECT_TRUE(hold(witness, {8.0, 0.0}, kHarmlessM));
  put(witness, 0, 5.0, 5.0);
  EXPECT_FALSE(hold(witness, {8.0, 0.0}, kHarmlessM)) << "too few";
}

/// A corridor whose walls have a pillar here and there.
test::Walls corridor() {
  test::Walls walls{{{-40.0, 0.0}, {40.0, 0.0}}, {{40.0, 2.4}, {-40.0, 2.4}}};
  for (const double x : {-9.0, -3.5, 1.0, 7.5, 11.0})
    walls = test::together({walls, test::rectangle({x, 0.0}, {x + 0.5, 0.35})});
  return walls;
}

/// Two visits of the corridor, with three submaps far away between them.
std::vector<SubmapRecord> two_visits() {
  const test::Scanner scanner{.angle_min_rad = -kPi, .beams = 720, .range_max_m = 12.0};
  std::vector<SubmapRecord> submaps;
  const auto visit = [&](double y) {
    const std::vector<Pose2> poses{{0.0, y, 0.0}, {1.0, y, 0.0}, {2.0, y, 0.0}};
    SubmapRecord& record = submaps.emplace_back();
    record.freeze(test::submap_seen_from(corridor(), poses, 0, scanner));
    record.map_T_submap = poses.front();
  };
  visit(1.0);
  for (std::size_t i = 1; i < 4; ++i) submaps.emplace_back().freeze(test::empty_submap(i));
  visit(1.3);
  return submaps;
}

TEST(LoopSurroundings, TheOtherSideOfAThinWallContradictsNothing) {
  const test::BothSides sides = test::both_sides_of_a_thin_wall();
  const Pose2& room_T_corridor = sides.room_T_corridor;
  const auto agreement = [&](const Pose2& pose) {
    return agreement_of(sides.room.submap, sides.corridor.submap, pose, {});
  };
  EXPECT_GT(agreement(room_T_corridor), 0.85);
  EXPECT_LT(agreement(Pose2{0.8, 0.0, 0.0} * room_T_corridor), 0.75);
  EXPECT_LT(agreement(Pose2{0.0, -0.6, 0.0} * room_T_corridor), 0.6);
  EXPECT_EQ(agreement(Pose2{50.0, 0.0, 0.0} * room_T_corridor), 0.0) << "they share nothing";
}

TEST(LoopSurroundings, AClosureAlongACorridorIsHeldWhereItsPillarsAre) {
  auto submaps = two_visits();
  LoopClosure closure;
  closure.from_submap = {0};
  closure.to_submap = {4};
  closure.from_T_to = submaps[0].map_T_submap.inverse() * submaps[4].map_T_submap;
  const Eigen::Vector2d pull(2.0, 0.0);
  const auto held = [&] {
    return hold(surroundings_of(closure, submaps, {}, {}), pull, kHarmlessM);
  };
  EXPECT_TRUE(held());
  closure.from_T_to.x += 2.0;
  EXPECT_FALSE(held());
}

}  // namespace
}  // namespace loopstone
