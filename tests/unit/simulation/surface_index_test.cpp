#include "loopstone/simulation/surface_index.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "loopstone/base/rng.hpp"
#include "loopstone/simulation/world.hpp"

namespace loopstone {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// All surfaces, one after the other.
double cast_naively(const FloorPlan& plan, const Eigen::Vector2d& origin,
                    const Eigen::Vector2d& direction, double max_range_m) {
  double nearest = kInfinity;
  for (const Segment& segment : flat_surfaces(plan)) {
    nearest = std::min(nearest, range_to(segment, origin, direction));
  }
  for (const Circle& circle : plan.circles)
    nearest = std::min(nearest, range_to(circle, origin, direction));
  return nearest <= max_range_m ? nearest : kInfinity;
}

double distance_naively(const FloorPlan& plan, const Eigen::Vector2d& point, double limit_m) {
  double nearest = limit_m;
  for (const Segment& segment : flat_surfaces(plan))
    nearest = std::min(nearest, distance_to(segment, point));
  for (const Circle& circle : plan.circles) nearest = std::min(nearest, distance_to(circle, point));
  return nearest;
}

Eigen::Vector2d heading(double yaw) { return {std::cos(yaw), std::sin(yaw)}; }

/// Boxes and circles of all sizes, thrown about; some outside the rest, some overlapping.
FloorPlan clutter(std::uint64_t seed) {
  Rng rng(seed);
  FloorPlan plan;
  for (int i = 0; i < 60; ++i) {
    plan.boxes.push_back(
        {{rng.uniform(-15.0, 15.0), rng.uniform(-10.0, 10.0), rng.uniform(-kPi, kPi)},
         std::exp(rng.uniform(-4.0, 2.0)),
         std::exp(rng.uniform(-4.0, 1.0))});
    plan.circles.push_back(
        {{rng.uniform(-15.0, 15.0), rng.uniform(-10.0, 10.0)}, std::exp(rng.uniform(-5.0, 0.5))});
  }
  plan.surfaces.push_back({{-20.0, 3.0}, {20.0, 3.5}});
  return plan;
}

TEST(RangeToSegment, IsMeasuredAlongTheRay) {
  const Segment wall{{2.0, -1.0}, {2.0, 1.0}};
  EXPECT_DOUBLE_EQ(range_to(wall, {0.0, 0.0}, {1.0, 0.0}), 2.0);
  EXPECT_DOUBLE_EQ(range_to(wall, {5.0, 0.0}, {-1.0, 0.0}), 3.0);
  EXPECT_NEAR(range_to(wall, {0.0, 0.0}, heading(std::atan2(1.0, 2.5))), 2.0 * std::hypot(1.0, 0.4),
              1e-12);
  EXPECT_EQ(range_to(wall, {0.0, 0.0}, {-1.0, 0.0}), kInfinity);
  EXPECT_EQ(range_to(wall, {0.0, 1.5}, {1.0, 0.0}), kInfinity);
  EXPECT_EQ(range_to(wall, {0.0, 0.0}, {0.0, 1.0}), kInfinity);
}

TEST(RangeToCircle, HitsTheNearSideAndTheFarSideFromWithin) {
  const Circle column{{3.0, 0.0}, 0.5};
  EXPECT_DOUBLE_EQ(range_to(column, {0.0, 0.0}, {1.0, 0.0}), 2.5);
  EXPECT_DOUBLE_EQ(range_to(column, {3.0, 0.0}, {0.0, 1.0}), 0.5);
  EXPECT_EQ(range_to(column, {0.0, 0.0}, {-1.0, 0.0}), kInfinity);
  EXPECT_EQ(range_to(column, {0.0, 0.6}, {1.0, 0.0}), kInfinity);
}

TEST(SurfaceIndex, CastsAsTheMinimumOverAllSurfaces) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const FloorPlan plan = clutter(seed);
    const SurfaceIndex index(plan);
    Rng rng(seed + 100);
    int hits = 0;
    for (int i = 0; i < 4000; ++i) {
      // From within and from outside; every tenth ray runs along an axis, where cell borders are.
      const Eigen::Vector2d origin(rng.uniform(-30.0, 30.0), rng.uniform(-20.0, 20.0));
      const Eigen::Vector2d direction =
          i % 10 == 0 ? Eigen::Vector2d(i % 20 == 0 ? 1.0 : 0.0, i % 20 == 0 ? 0.0 : -1.0)
                      : heading(rng.uniform(-kPi, kPi));
      const double max_range = i % 3 == 0 ? 8.0 : 100.0;
      const double range = index.cast(origin, direction, max_range);
      EXPECT_EQ(range, cast_naively(plan, origin, direction, max_range))
          << "ray " << i << " of seed " << seed;
      const SurfaceHit hit = index.hit(origin, direction, max_range);
      EXPECT_EQ(hit.range_m, range);
      EXPECT_EQ(hit.surface == SurfaceHit::kNothing, !std::isfinite(range));
      if (std::isfinite(range)) {
        EXPECT_EQ(index.range_to_surface(hit.surface, origin, direction), range);
      }
      hits += std::isfinite(range) ? 1 : 0;
    }
    EXPECT_GT(hits, 1000);
  }
}

TEST(SurfaceIndex, CastsFromCellBordersAndCorners) {
  const FloorPlan plan = clutter(7);
  const SurfaceIndex index(plan, 0.5);
  for (int i = 0; i < 720; ++i) {
    const Eigen::Vector2d origin(0.5 * (i % 13) - 3.0, 0.5 * (i % 7) - 2.0);
    const Eigen::Vector2d direction = heading(radians(0.5 * i));
    EXPECT_EQ(index.cast(origin, direction, 50.0), cast_naively(plan, origin, direction, 50.0))
        << i;
  }
}

TEST(SurfaceIndex, LosesNoRayInTheCornersOfABox) {
  FloorPlan plan;
  plan.boxes.push_back({{1.0, 2.0, 0.3}, 6.0, 4.0});
  const SurfaceIndex index(plan);
  for (const Segment& side : outline(plan.boxes.front())) {
    for (const Eigen::Vector2d& corner : {side.from, side.to}) {
      const Eigen::Vector2d origin(1.3, 2.2);
      const Eigen::Vector2d to_corner = corner - origin;
      EXPECT_NEAR(index.cast(origin, to_corner.normalized(), 100.0), to_corner.norm(), 1e-6);
    }
  }
}

TEST(SurfaceIndex, MeasuresDistanceAsTheMinimumOverAllSurfaces) {
  const FloorPlan plan = clutter(4);
  const SurfaceIndex index(plan);
  Rng rng(5);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2d point(rng.uniform(-18.0, 18.0), rng.uniform(-12.0, 12.0));
    EXPECT_EQ(index.distance(point, 1.0), distance_naively(plan, point, 1.0));
  }
}

TEST(SurfaceIndex, FindsNothingInAnEmptyPlan) {
  const SurfaceIndex index(FloorPlan{});
  EXPECT_EQ(index.cast({0.1, 0.1}, {1.0, 0.0}, 100.0), kInfinity);
  EXPECT_EQ(index.distance({0.0, 0.0}, 2.0), 2.0);
}

TEST(SurfaceIndex, CastsInABuildingAsTheMinimumOverAllSurfaces) {
  const World world = make_world("office", 3);
  const SurfaceIndex index(world.plan);
  const Eigen::Vector2d origin = world.map_T_start.translation();
  for (int i = 0; i < 360; ++i) {
    const Eigen::Vector2d direction = heading(radians(i));
    EXPECT_EQ(index.cast(origin, direction, 30.0),
              cast_naively(world.plan, origin, direction, 30.0));
  }
}

}  // namespace
}  // namespace loopstone
