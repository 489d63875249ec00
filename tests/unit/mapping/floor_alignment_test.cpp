#include "mapping/floor_alignment.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "loopstone/base/linear_light.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "support/rendered_floor.hpp"

namespace loopstone {
namespace {

constexpr double kNoise_per_m = 0.003;

FloorAligner aligner_of(const CameraModel& camera) {
  return {camera, floor_plane_of(camera.robot_T_camera), kNoise_per_m};
}

struct Pair {
  Pose2 from_T_to;
  RgbdImages from;
  RgbdImages to;
};

/// A robot somewhere on the floor, and a few centimetres and degrees further.
Pair some_pair(const test::FloorScene& scene, const CameraModel& camera, Rng& rng) {
  const Pose2 from{rng.uniform(-3.0, 3.0), rng.uniform(-3.0, 3.0), rng.uniform(-kPi, kPi)};
  const Pose2 motion{rng.uniform(0.0, 0.12), rng.uniform(-0.01, 0.01), rng.uniform(-0.1, 0.1)};
  const Pose2 to = from * motion;
  return {motion, test::render(scene, camera, from, from, 3, true),
          test::render(scene, camera, to, to, 3, true)};
}

struct Error {
  double place_m;
  double yaw_deg;
};
Error error_of(const Pose2& found, const Pose2& truth) {
  const Pose2 off = truth.inverse() * found;
  return {off.translation().norm(), std::abs(degrees(off.yaw))};
}

TEST(FloorAlignment, FindsHowTheRobotMoved) {
  const test::FloorScene scene{test::wavy_floor};
  const CameraModel camera = test::small_camera();
  FloorAligner aligner = aligner_of(camera);
  Rng rng(4);
  for (int i = 0; i < 12; ++i) {
    const Pair pair = some_pair(scene, camera, rng);
    const double direction = rng.uniform(-kPi, kPi);
    const double turn = rng.uniform() < 0.5 ? radians(1.0) : radians(-1.0);
    const std::array<Pose2, 1> guess{
        pair.from_T_to * Pose2{0.02 * std::cos(direction), 0.02 * std::sin(direction), turn}};
    const std::optional<FloorMotion> motion = aligner.align(pair.from, pair.to, guess);
    ASSERT_TRUE(motion) << i;
    const Error error = error_of(motion->from_T_to, pair.from_T_to);
    EXPECT_LT(error.place_m, 0.001) << i;
    EXPECT_LT(error.yaw_deg, 0.05) << i;
    EXPECT_GT(motion->correlation, 0.95);
  }
}

TEST(FloorAlignment, ErrorsAreWhatTheCovarianceSays) {
  const test::FloorScene scene{test::wavy_floor};
  const CameraModel camera = test::small_camera();
  FloorAligner aligner = aligner_of(camera);
  Rng rng(5);
  for (int i = 0; i < 12; ++i) {
    Pair pair = some_pair(scene, camera, rng);
    for (RgbdImages* images : {&pair.from, &pair.to}) {
      for (std::uint8_t& value : images->colour.rgb) {
        value = static_cast<std::uint8_t>(
            std::clamp(std::lround(value + rng.normal(0.0, 6.0)), 0L, 255L));
      }
    }
    const std::array<Pose2, 1> guess{pair.from_T_to};
    const std::optional<FloorMotion> motion = aligner.align(pair.from, pair.to, guess);
    ASSERT_TRUE(motion) << i;
    const Eigen::Vector3d error(motion->from_T_to.x - pair.from_T_to.x,
                                motion->from_T_to.y - pair.from_T_to.y,
                                wrap_angle(motion->from_T_to.yaw - pair.from_T_to.yaw));
    const Eigen::LLT<Eigen::Matrix3d> factor(motion->covariance);
    ASSERT_EQ(factor.info(), Eigen::Success) << "positive definite";
    EXPECT_TRUE(motion->covariance.isApprox(motion->covariance.transpose()));
    for (int k = 0; k < 3; ++k) {
      EXPECT_LT(std::abs(error[k]), 4.0 * std::sqrt(motion->covariance(k, k))) << i << " " << k;
    }
    EXPECT_LT(std::sqrt(motion->covariance(0, 0)), 0.005);
    EXPECT_LT(degrees(std::sqrt(motion->covariance(2, 2))), 0.3);
  }
}

TEST(FloorAlignment, BrightnessAndContrastMayChange) {
  const test::FloorScene scene{test::wavy_floor};
  const CameraModel camera = test::small_camera();
  FloorAligner aligner = aligner_of(camera);
  Rng rng(6);
  Pair pair = some_pair(scene, camera, rng);
  for (std::uint8_t& value : pair.to.colour.rgb) {
    value = static_cast<std::uint8_t>(
        std::lround(255.0 * srgb_of_linear(0.6 * linear_of_srgb(value / 255.0))));
  }
  const std::array<Pose2, 1> guess{pair.from_T_to * Pose2{0.01, -0.01, 0.01}};
  const std::optional<FloorMotion> motion = aligner.align(pair.from, pair.to, guess);
  ASSERT_TRUE(motion);
  EXPECT_LT(error_of(motion->from_T_to, pair.from_T_to).place_m, 0.001);
}

TEST(FloorAlignment, TheBestGuessIsTaken) {
  const test::FloorScene scene{test::wavy_floor};
  const CameraModel camera = test::small_camera();
  FloorAligner aligner = aligner_of(camera);
  Rng rng(7);
  const Pair pair = some_pair(scene, camera, rng);
  const Pose2 good = pair.from_T_to * Pose2{0.01, 0.01, 0.01};
  const std::array<Pose2, 3> guesses{pair.from_T_to * Pose2{0.1, 0.05, 0.1}, good,
                                     pair.from_T_to * Pose2{-0.08, 0.06, -0.1}};
  const std::array<Pose2, 1> only{good};
  const std::optional<FloorMotion> of_three = aligner.align(pair.from, pair.to, guesses);
  const std::optional<FloorMotion> of_one = aligner.align(pair.from, pair.to, only);
  ASSERT_TRUE(of_three);
  ASSERT_TRUE(of_one);
  EXPECT_EQ(of_three->from_T_to, of_one->from_T_to);
}

TEST(FloorAlignment, SaysNothingWithoutStructureOrFloorOrAgreement) {
  const CameraModel camera = test::small_camera();
  FloorAligner aligner = aligner_of(camera);
  const std::array<Pose2, 1> guess{Pose2{0.05, 0.0, 0.0}};
  const auto align = [&](const test::FloorScene& scene, const Pose2& from, const Pose2& to) {
    return aligner.align(test::render(scene, camera, from, from, 1),
                         test::render(scene, camera, to, to, 1), guess);
  };
  const test::FloorScene bare{[](double, double) { return Eigen::Vector3d(0.4, 0.5, 0.6); }};
  EXPECT_FALSE(align(bare, {}, {0.05, 0.0, 0.0}));
  // A wall stands right before the camera.
  const test::FloorScene walled{test::wavy_floor, {{{0.5, -2.0, 0.0}, {0.6, 2.0, 2.0}}}};
  EXPECT_FALSE(align(walled, {}, {0.05, 0.0, 0.0}));
  // Two other places.
  const test::FloorScene floor{test::wavy_floor};
  EXPECT_FALSE(align(floor, {}, {1.9, 1.3, 2.0}));
  EXPECT_TRUE(align(floor, {}, {0.05, 0.0, 0.0})) << "the same with floor that both see";
}

TEST(FloorAlignment, ThingsOnTheFloorDoNotPull) {
  const test::FloorScene scene{test::wavy_floor, {{{0.9, -0.1, 0.0}, {1.0, 0.1, 0.4}}}};
  const CameraModel camera = test::small_camera();
  FloorAligner aligner = aligner_of(camera);
  const Pose2 truth{0.06, 0.0, 0.05};
  const std::array<Pose2, 1> guess{truth * Pose2{-0.01, 0.01, 0.01}};
  const std::optional<FloorMotion> motion =
      aligner.align(test::render(scene, camera, {}, {}, 3, true),
                    test::render(scene, camera, truth, truth, 3, true), guess);
  ASSERT_TRUE(motion);
  EXPECT_LT(error_of(motion->from_T_to, truth).place_m, 0.0015);
  EXPECT_LT(error_of(motion->from_T_to, truth).yaw_deg, 0.1);
}

}  // namespace
}  // namespace loopstone
