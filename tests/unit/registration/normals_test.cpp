#include "loopstone/registration/normals.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

using Planar = std::vector<Eigen::Vector2d>;
using Spatial = std::vector<Eigen::Vector3d>;

TEST(SurfacePatches, StandAcrossALineOfAnyDirection) {
  for (int degree = 0; degree < 180; degree += 15) {
    const Eigen::Vector2d direction(std::cos(radians(degree)), std::sin(radians(degree)));
    Planar line;
    for (int i = 0; i < 20; ++i) line.push_back(0.05 * i * direction);
    for (const auto& patch : surface_patches<2>(PointIndex<2>(line))) {
      EXPECT_TRUE(patch.flat);
      EXPECT_NEAR(patch.normal.norm(), 1.0, 1e-12);
      EXPECT_NEAR(patch.normal.dot(direction), 0.0, 1e-9);
      EXPECT_NEAR(patch.normal.dot(patch.anchor), 0.0, 1e-9);
      EXPECT_NEAR(patch.thickness_m, 0.0, 1e-8);
    }
  }
}

TEST(SurfacePatches, StandAcrossAPlaneOfAnyDirection) {
  Rng rng(41);
  for (int draw = 0; draw < 20; ++draw) {
    const Eigen::Vector3d normal =
        Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal()).normalized();
    const Eigen::Vector3d u = normal.unitOrthogonal();
    const Eigen::Vector3d v = normal.cross(u);
    Spatial plane;
    for (int i = 0; i < 200; ++i) {
      plane.push_back(normal + rng.uniform(-0.5, 0.5) * u + rng.uniform(-0.5, 0.5) * v);
    }
    for (const auto& patch : surface_patches<3>(PointIndex<3>(plane))) {
      if (!patch.flat) continue;  // neighbours that happen to stand in a row
      EXPECT_NEAR(std::abs(patch.normal.dot(normal)), 1.0, 1e-6);
    }
  }
}

TEST(SurfacePatches, AreMissingInClutterAndForLonePoints) {
  Rng rng(42);
  Planar points;
  for (int i = 0; i < 300; ++i) points.emplace_back(rng.uniform(-3.0, 3.0), rng.uniform(-3.0, 3.0));
  points.emplace_back(100.0, 100.0);
  points.emplace_back(std::numeric_limits<double>::quiet_NaN(), 0.0);
  PatchOptions<2> options;
  options.neighbours = 20;
  options.reach_m = 5.0;
  const auto patches = surface_patches<2>(PointIndex<2>(points), options);
  ASSERT_EQ(patches.size(), points.size());
  EXPECT_FALSE(patches[300].flat);
  EXPECT_FALSE(patches[301].flat);
  EXPECT_TRUE(patches[301].normal.isZero());
  EXPECT_LT(std::count_if(patches.begin(), patches.end(), [](const auto& p) { return p.flat; }),
            60);
}

TEST(SurfacePatches, KnowHowThickTheSurfaceIs) {
  Rng rng(43);
  Planar wall;
  for (int i = 0; i < 4000; ++i) wall.emplace_back(0.01 * i, rng.normal(0.0, 0.005));
  std::vector<double> variances;
  double sum = 0.0;
  const auto patches = surface_patches<2>(PointIndex<2>(wall));
  for (const auto& patch : patches) sum += patch.thickness_m * patch.thickness_m;
  EXPECT_NEAR(std::sqrt(sum / static_cast<double>(patches.size())), 0.005, 0.0003);
  // The mean of many is closer to the wall than each.
  double squared = 0.0;
  for (const auto& patch : patches) squared += patch.anchor.y() * patch.anchor.y();
  EXPECT_LT(std::sqrt(squared / static_cast<double>(patches.size())), 0.002);
}

TEST(SurfacePatches, PassThroughThePointWhenNotSmooth) {
  Rng rng(44);
  Planar wall;
  for (int i = 0; i < 50; ++i) wall.emplace_back(0.05 * i, rng.normal(0.0, 0.005));
  PatchOptions<2> options;
  options.smooth = false;
  const auto patches = surface_patches<2>(PointIndex<2>(wall), options);
  for (std::size_t i = 0; i < wall.size(); ++i) EXPECT_EQ(patches[i].anchor, wall[i]);
}

}  // namespace
}  // namespace loopstone
