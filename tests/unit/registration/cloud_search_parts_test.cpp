// The parts that the search of clouds is made of, against naive twins.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "cloud_search_shapes.hpp"
#include "loopstone/registration/distance_field.hpp"
#include "registration/cloud_search_sample.hpp"
#include "registration/cloud_search_starts.hpp"

namespace loopstone {
namespace {

template <int kDimension>
using Singles = std::vector<Eigen::Matrix<float, kDimension, 1>>;

template <int kDimension>
Singles<kDimension> random_points(std::size_t count, float extent, Rng& rng) {
  Singles<kDimension> points(count);
  for (auto& point : points) {
    for (int k = 0; k < kDimension; ++k) {
      point(k) = static_cast<float>(rng.uniform(-extent, extent));
    }
  }
  return points;
}

template <int kDimension>
void expect_nearest_point_of_brute_force(std::size_t count, float resolution_m) {
  Rng rng(31);
  const auto points = random_points<kDimension>(count, 1.0F, rng);
  const DistanceField<kDimension> field(
      points, voxels_covering<kDimension>(points, resolution_m, 0.3F, 1 << 20));
  // Inside, around, and far outside the block of voxels; with hints and without.
  for (const float extent : {1.0F, 1.6F, 20.0F}) {
    for (const auto& query : random_points<kDimension>(150, extent, rng)) {
      float least = std::numeric_limits<float>::infinity();
      for (const auto& point : points) least = std::min(least, (point - query).squaredNorm());
      const auto hint = static_cast<std::int32_t>(rng.below(count));
      for (const auto& nearest : {field.nearest_point(query), field.nearest_point(query, hint)}) {
        EXPECT_FLOAT_EQ(nearest.squared_distance_m2, least);
        EXPECT_EQ((field.points()[static_cast<std::size_t>(nearest.point)] - query).squaredNorm(),
                  nearest.squared_distance_m2);
      }
    }
  }
}

TEST(DistanceField, FindsTheNearestPointThatBruteForceFinds) {
  expect_nearest_point_of_brute_force<2>(300, 0.08F);
  expect_nearest_point_of_brute_force<2>(5, 0.3F);
  expect_nearest_point_of_brute_force<3>(300, 0.2F);
  expect_nearest_point_of_brute_force<3>(40, 0.05F);
}

template <int kDimension>
void expect_nearest_voxels_of_brute_force() {
  Rng rng(32);
  const auto points = random_points<kDimension>(25, 1.0F, rng);
  const auto frame = voxels_covering<kDimension>(points, 0.17F, 0.2F, 1 << 20);
  const DistanceField<kDimension> field(points, frame);
  const auto place_of = [&](std::size_t voxel) {
    std::array<std::int64_t, kDimension> place{};
    for (std::size_t a = 0; a < kDimension; ++a) {
      place[a] = static_cast<std::int64_t>(voxel % static_cast<std::size_t>(frame.counts[a]));
      voxel /= static_cast<std::size_t>(frame.counts[a]);
    }
    return place;
  };
  const auto squared_distance = [](const auto& a, const auto& b) {
    std::int64_t sum = 0;
    for (std::size_t k = 0; k < a.size(); ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
    return sum;
  };
  std::vector<std::size_t> occupied;
  for (const auto& site : field.sites()) occupied.push_back(frame.nearest_voxel(site));
  ASSERT_EQ(field.nearest().size(), frame.size());
  for (std::size_t voxel = 0; voxel < frame.size(); ++voxel) {
    std::int64_t least = std::numeric_limits<std::int64_t>::max();
    for (const std::size_t other : occupied) {
      least = std::min(least, squared_distance(place_of(voxel), place_of(other)));
    }
    const auto found = occupied[static_cast<std::size_t>(field.nearest()[voxel])];
    ASSERT_EQ(squared_distance(place_of(voxel), place_of(found)), least) << voxel;
  }
}

TEST(DistanceField, KnowsTheNearestOccupiedVoxelOfEveryVoxel) {
  expect_nearest_voxels_of_brute_force<2>();
  expect_nearest_voxels_of_brute_force<3>();
}

TEST(DistanceField, CoarsensTheVoxelsToStayWithinBounds) {
  const Singles<3> points{{0.0F, 0.0F, 0.0F}, {100.0F, 100.0F, 100.0F}};
  const auto frame = voxels_covering<3>(points, 0.1F, 1.0F, 5000);
  EXPECT_LE(frame.size(), 5000U);
  EXPECT_GT(frame.size(), 1000U);
  for (const auto& point : points) EXPECT_TRUE(frame.contains(point));
}

TEST(DistanceField, TellsWhichWayAPlaneFaces) {
  Rng rng(33);
  Singles<3> points;
  for (int i = 0; i < 2000; ++i) {
    points.emplace_back(static_cast<float>(rng.uniform()), static_cast<float>(rng.uniform()),
                        static_cast<float>(0.002 * rng.normal()));
  }
  const DistanceField<3> field(points, voxels_covering<3>(points, 0.1F, 0.1F, 1 << 20));
  const Eigen::Vector3f normal = field.normal_near({0.5F, 0.5F, 0.0F});
  EXPECT_GT(std::abs(normal.z()), 0.999F);
}

double angle_between(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return Eigen::AngleAxisd(a * b.transpose()).angle();
}

TEST(EvenRotations, LeaveNoTurnFarAway) {
  const auto rotations = even_rotations<3>(256, false);
  EXPECT_EQ(rotations.size(), 256U);
  Rng rng(34);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Matrix3d any = test::random_motion(rng, Pose3{}).rotation.toRotationMatrix();
    double least = 10.0;
    for (const auto& rotation : rotations) least = std::min(least, angle_between(any, rotation));
    EXPECT_LT(least, 0.75);
  }
}

TEST(EvenRotations, AreTheSameWhateverTheSignsOfPrincipalAxes) {
  for (const bool upright : {false, true}) {
    const auto rotations = even_rotations<3>(upright ? 17 : 108, upright);
    for (const auto& signs : {Eigen::Vector3d(1.0, -1.0, -1.0), Eigen::Vector3d(-1.0, 1.0, -1.0),
                              Eigen::Vector3d(-1.0, -1.0, 1.0)}) {
      if (upright && signs.z() < 0.0) continue;
      const Eigen::Matrix3d flip = signs.asDiagonal();
      for (const auto& rotation : rotations) {
        for (const Eigen::Matrix3d& flipped :
             {Eigen::Matrix3d(flip * rotation), Eigen::Matrix3d(rotation * flip)}) {
          EXPECT_TRUE(std::any_of(rotations.begin(), rotations.end(), [&](const auto& other) {
            return (other - flipped).norm() < 1e-9;
          }));
        }
      }
    }
  }
}

TEST(EvenRotations, OfThePlaneAreEvenlySpacedYaws) {
  const auto rotations = even_rotations<2>(36, false);
  ASSERT_EQ(rotations.size(), 36U);
  for (std::size_t i = 1; i < rotations.size(); ++i) {
    const Eigen::Matrix2d step = rotations[i] * rotations[i - 1].transpose();
    EXPECT_NEAR(std::atan2(step(1, 0), step(0, 0)), 2.0 * 3.14159265358979 / 36.0, 1e-9);
  }
}

TEST(SpreadSample, IsOfAboutTheSizeAskedForAndCoversTheCloud) {
  Rng rng(35);
  const auto surface =
      test::sample_surface<3>(test::tool(), 20000, 0.0, Eigen::Vector3d::Zero(), rng);
  Singles<3> points;
  for (const auto& point : surface) points.push_back(point.cast<float>());
  for (const std::size_t count : {80U, 2000U}) {
    const auto sample = spread_sample<3>(points, count);
    EXPECT_NEAR(static_cast<double>(sample.size()), static_cast<double>(count),
                0.2 * static_cast<double>(count));
    EXPECT_EQ(std::set<std::size_t>(sample.begin(), sample.end()).size(), sample.size());
    float farthest = 0.0F;
    for (const auto& point : points) {
      float least = 1.0F;
      for (const std::size_t i : sample) least = std::min(least, (points[i] - point).norm());
      farthest = std::max(farthest, least);
    }
    EXPECT_LT(farthest, count == 80 ? 0.1F : 0.02F);
  }
}

TEST(Descend, RollsDownToWhereTheCloudLies) {
  Rng rng(36);
  const auto surface =
      test::sample_surface<3>(test::tool(), 4000, 0.0, Eigen::Vector3d::Zero(), rng);
  Singles<3> points;
  for (const auto& point : surface) points.push_back(point.cast<float>());
  const DistanceField<3> field(points, voxels_covering<3>(points, 0.004F, 0.02F, 1 << 20));
  const auto few = few_points<3>(points, spread_sample<3>(points, 100));
  Start<3> start;
  start.rotation = Eigen::AngleAxisf(0.2F, Eigen::Vector3f(1, 2, 3).normalized()).matrix();
  start.translation = {0.01F, -0.02F, 0.01F};
  const auto before = descend<3>(field, few, 1.0, 0, start);
  const auto after = descend<3>(field, few, 1.0, 20, start);
  EXPECT_EQ(before.rotation, start.rotation);
  EXPECT_LT(after.rmse_m, 0.2F * before.rmse_m);
  EXPECT_LT(after.translation.norm(), 0.004F);
  EXPECT_LT((after.rotation - Eigen::Matrix3f::Identity()).norm(), 0.05F);
}

}  // namespace
}  // namespace loopstone
