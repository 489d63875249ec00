#include "loopstone/geometry/rigid_alignment.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

template <int kDimension>
using Points = std::vector<Eigen::Matrix<double, kDimension, 1>>;

template <int kDimension>
Points<kDimension> random_points(std::size_t count, Rng& rng) {
  Points<kDimension> points(count);
  for (auto& point : points) {
    for (int k = 0; k < kDimension; ++k) point(k) = rng.uniform(-5.0, 5.0);
  }
  return points;
}

template <int kDimension>
RigidAlignment<kDimension> align(const Points<kDimension>& source, const Points<kDimension>& target,
                                 const std::vector<double>& weights = {}) {
  return align_rigidly<kDimension>(source, target, weights);
}

template <int kDimension>
double squared_error(const RigidAlignment<kDimension>& t, const Points<kDimension>& source,
                     const Points<kDimension>& target) {
  double sum = 0.0;
  for (std::size_t i = 0; i < source.size(); ++i) {
    sum += (t.rotation * source[i] + t.translation - target[i]).squaredNorm();
  }
  return sum;
}

TEST(RigidAlignment, RecoversAnyPlanarMotion) {
  Rng rng(1);
  for (const double yaw : {0.0, 1e-9, 0.5, -2.0, kPi}) {
    const Pose2 truth{3.0, -4.0, yaw};
    const auto source = random_points<2>(10, rng);
    Points<2> target;
    for (const auto& p : source) target.push_back(truth * p);
    const auto found = align<2>(source, target);
    EXPECT_TRUE(found.unique);
    const Pose2 pose = to_pose(found);
    EXPECT_NEAR(pose.x, truth.x, 1e-12);
    EXPECT_NEAR(pose.y, truth.y, 1e-12);
    EXPECT_NEAR(wrap_angle(pose.yaw - yaw), 0.0, 1e-12);
  }
}

TEST(RigidAlignment, RecoversAnySpatialMotion) {
  Rng rng(2);
  for (int trial = 0; trial < 20; ++trial) {
    const Pose3 truth = Pose3::from_roll_pitch_yaw({rng.normal(), rng.normal(), rng.normal()},
                                                   rng.uniform(-kPi, kPi), rng.uniform(-1.5, 1.5),
                                                   rng.uniform(-kPi, kPi));
    const auto source = random_points<3>(10, rng);
    Points<3> target;
    for (const auto& p : source) target.push_back(truth * p);
    const auto found = align<3>(source, target);
    EXPECT_TRUE(found.unique);
    EXPECT_LT(squared_error<3>(found, source, target), 1e-20);
    EXPECT_LT((to_pose(found).translation - truth.translation).norm(), 1e-12);
    EXPECT_LT(to_pose(found).rotation.angularDistance(truth.rotation), 1e-7);
  }
}

TEST(RigidAlignment, NeverMirrors) {
  Rng rng(3);
  auto plane = random_points<2>(20, rng);
  auto mirrored_plane = plane;
  for (auto& p : mirrored_plane) p.x() = -p.x();
  EXPECT_NEAR(align<2>(plane, mirrored_plane).rotation.determinant(), 1.0, 1e-12);
  auto space = random_points<3>(20, rng);
  auto mirrored_space = space;
  for (auto& p : mirrored_space) p.z() = -p.z();
  EXPECT_NEAR(align<3>(space, mirrored_space).rotation.determinant(), 1.0, 1e-12);
}

TEST(RigidAlignment, IsBetterThanEveryRotationOnAGrid) {
  Rng rng(4);
  const auto source = random_points<2>(15, rng);
  const auto target =
      random_points<2>(15, rng);  // nothing to do with the source: a mirror image fits as well
  const auto found = align<2>(source, target);
  const double best = squared_error<2>(found, source, target);
  Eigen::Vector2d source_mean = Eigen::Vector2d::Zero();
  Eigen::Vector2d target_mean = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < 15; ++i) {
    source_mean += source[i] / 15.0;
    target_mean += target[i] / 15.0;
  }
  for (int degree = -180; degree < 180; ++degree) {
    RigidAlignment<2> other;
    other.rotation = Pose2{0.0, 0.0, radians(degree)}.rotation();
    other.translation = target_mean - other.rotation * source_mean;
    EXPECT_GE(squared_error<2>(other, source, target), best - 1e-9);
  }
}

TEST(RigidAlignment, PairsOfWeightZeroDoNotCount) {
  Rng rng(5);
  auto source = random_points<2>(6, rng);
  auto target = source;
  target.back() += Eigen::Vector2d(100.0, 50.0);
  std::vector<double> weights(6, 2.0);
  weights.back() = 0.0;
  const Pose2 pose = to_pose(align<2>(source, target, weights));
  EXPECT_LT(pose.vector().norm(), 1e-12);
}

TEST(RigidAlignment, SaysWhenTheRotationIsOpen) {
  EXPECT_FALSE(align<2>({}, {}).unique);
  EXPECT_FALSE(align<2>({{1.0, 2.0}}, {{3.0, 4.0}}).unique);
  EXPECT_FALSE(
      align<3>({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}).unique);
  EXPECT_TRUE(align<2>({{0, 0}, {1, 0}, {2, 0}}, {{0, 0}, {0, 1}, {0, 2}}).unique);
  EXPECT_TRUE(
      align<3>({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}).unique);
  const auto shifted = align<2>({{1.0, 2.0}}, {{3.0, 4.0}});
  EXPECT_LT((shifted.rotation * Eigen::Vector2d(1.0, 2.0) + shifted.translation -
             Eigen::Vector2d(3.0, 4.0))
                .norm(),
            1e-12);
}

}  // namespace
}  // namespace loopstone
