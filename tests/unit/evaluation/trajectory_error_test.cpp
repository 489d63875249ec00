#include "loopstone/evaluation/trajectory_error.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using test::pose_near;

Stamp at(double seconds) { return Stamp::from_seconds(seconds); }

Trajectory winding_path(int count = 200) {
  Trajectory path;
  Pose2 pose;
  for (int i = 0; i < count; ++i) {
    path.append(at(0.1 * i), pose);
    pose = pose * exp(Tangent2{0.1, 0.0, 0.05 * std::sin(0.07 * i)});
  }
  return path;
}

Trajectory moved(const Trajectory& path, const Pose2& new_T_old) {
  Trajectory result;
  for (const StampedPose2& pose : path.poses()) result.append(pose.stamp, new_T_old * pose.pose);
  return result;
}

TEST(Statistics, OfAKnownSample) {
  const ErrorStatistics s = statistics_of({4.0, 1.0, 3.0, 2.0});
  EXPECT_DOUBLE_EQ(s.mean, 2.5);
  EXPECT_DOUBLE_EQ(s.std, std::sqrt(5.0 / 3.0)) << "with n - 1";
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(7.5));
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.max, 4.0);
  EXPECT_DOUBLE_EQ(statistics_of({1.0, 9.0, 2.0}).median, 2.0);
}

TEST(Statistics, OfOneAndOfNone) {
  EXPECT_EQ(statistics_of({3.0}).std, 0.0);
  EXPECT_EQ(statistics_of({}).rmse, 0.0);
}

TEST(AlignTrajectories, FindsTheMotionThatWasApplied) {
  Rng rng(3);
  for (int i = 0; i < 50; ++i) {
    const Pose2 reference_T_estimate{rng.uniform(-50, 50), rng.uniform(-50, 50),
                                     rng.uniform(-kPi, kPi)};
    std::vector<Pose2> estimate;
    std::vector<Pose2> reference;
    for (int k = 0; k < 10; ++k) {
      estimate.push_back({rng.uniform(-5, 5), rng.uniform(-5, 5), rng.uniform(-kPi, kPi)});
      reference.push_back(reference_T_estimate * estimate.back());
    }
    EXPECT_TRUE(
        pose_near(align_trajectories(estimate, reference), reference_T_estimate, 1e-9, 1e-9));
  }
}

TEST(AlignTrajectories, IsTheBestOfAllMotionsNearby) {
  Rng rng(5);
  std::vector<Pose2> estimate;
  std::vector<Pose2> reference;
  for (int k = 0; k < 30; ++k) {
    estimate.push_back({rng.uniform(-5, 5), rng.uniform(-5, 5), 0.0});
    reference.push_back(Pose2{1.0, 2.0, 0.7} * estimate.back());
    reference.back().x += rng.normal(0.0, 0.3);
    reference.back().y += rng.normal(0.0, 0.3);
  }
  const auto cost = [&](const Pose2& reference_T_estimate) {
    double sum = 0.0;
    for (std::size_t i = 0; i < estimate.size(); ++i) {
      sum += (reference_T_estimate * estimate[i].translation() - reference[i].translation())
                 .squaredNorm();
    }
    return sum;
  };
  const Pose2 best = align_trajectories(estimate, reference);
  for (const double step : {1e-3, -1e-3}) {
    EXPECT_LT(cost(best), cost({best.x + step, best.y, best.yaw}));
    EXPECT_LT(cost(best), cost({best.x, best.y + step, best.yaw}));
    EXPECT_LT(cost(best), cost({best.x, best.y, best.yaw + step}));
  }
}

TEST(AlignTrajectories, OfARobotThatStandsTakesTheHeading) {
  const std::vector<Pose2> estimate(5, Pose2{1.0, 1.0, 0.2});
  const std::vector<Pose2> reference(5, Pose2{-3.0, 2.0, -1.0});
  const Pose2 found = align_trajectories(estimate, reference);
  EXPECT_TRUE(pose_near(found * estimate[0], reference[0], 1e-12, 1e-12));
}

TEST(AbsoluteError, OfAMovedCopyIsZeroOnlyWhenAligned) {
  const Trajectory reference = winding_path();
  const Trajectory estimate = moved(reference, {3.0, -4.0, 2.0});
  const AbsoluteError aligned = absolute_error(estimate, reference, Alignment::kSe2);
  EXPECT_LT(aligned.translation_m.max, 1e-9);
  EXPECT_LT(aligned.rotation_rad.max, 1e-9);
  const AbsoluteError raw = absolute_error(estimate, reference, Alignment::kNone);
  EXPECT_GT(raw.translation_m.mean, 1.0);
  EXPECT_NEAR(raw.rotation_rad.mean, 2.0, 1e-9);
}

TEST(AbsoluteError, CountsWhatLiesOutsideAndInterpolatesWhatLiesBetween) {
  const Trajectory reference = winding_path(100);
  Trajectory sparse;
  for (std::size_t i = 20; i < 80; i += 5) {
    sparse.append(reference.poses()[i].stamp, reference.poses()[i].pose);
  }
  const AbsoluteError error = absolute_error(sparse, reference, Alignment::kNone);
  EXPECT_EQ(error.poses, 56);  // 20 to 75
  EXPECT_EQ(error.poses_missing, 44);
  EXPECT_LT(error.translation_m.max, 1e-3);
}

TEST(AbsoluteError, TellsTheErrorOfEachPose) {
  const std::vector<StampedPose2> truth{
      {Stamp{0}, {}}, {Stamp{1}, {1.0, 0.0, 0.0}}, {Stamp{2}, {2.0, 0.0, 0.0}}};
  const std::vector<StampedPose2> found{
      {Stamp{0}, {}}, {Stamp{1}, {1.0, 0.3, -0.1}}, {Stamp{2}, {2.0, 0.4, 0.0}}};
  const AbsoluteError error =
      absolute_error(Trajectory(found), Trajectory(truth), Alignment::kNone);
  EXPECT_EQ(error.by_pose.stamps, (std::vector<Stamp>{{0}, {1}, {2}}));
  ASSERT_EQ(error.by_pose.translation_m.size(), 3U);
  EXPECT_DOUBLE_EQ(error.by_pose.translation_m[1], 0.3);
  EXPECT_DOUBLE_EQ(error.by_pose.rotation_rad[1], 0.1);
  const RelativeError steps =
      relative_error(Trajectory(found), Trajectory(truth), 1, Spacing::kFrames);
  EXPECT_EQ(steps.by_pair.stamps, (std::vector<Stamp>{{0}, {1}}));
  EXPECT_DOUBLE_EQ(steps.by_pair.translation_m[0], 0.3);
  EXPECT_EQ(steps.by_pair.rotation_rad.size(), 2U);
}

TEST(AbsoluteError, HeadingErrorsAreWrappedAndUnsigned) {
  Trajectory reference;
  Trajectory estimate;
  reference.append(at(0.0), {0.0, 0.0, kPi - 0.05});
  estimate.append(at(0.0), {0.0, 0.0, -kPi + 0.05});
  const AbsoluteError error = absolute_error(estimate, reference, Alignment::kNone);
  EXPECT_NEAR(error.rotation_rad.mean, 0.1, 1e-12);
}

TEST(RelativeError, DoesNotDependOnTheFrame) {
  const Trajectory reference = winding_path();
  Trajectory drifting;
  Pose2 pose{5.0, 5.0, 1.0};
  for (std::size_t i = 0; i < reference.size(); ++i) {
    drifting.append(reference.poses()[i].stamp, pose);
    if (i + 1 < reference.size()) {
      pose = pose * (reference.poses()[i].pose.inverse() * reference.poses()[i + 1].pose) *
             Pose2{0.001, 0.0, 0.0};
    }
  }
  const RelativeError here = relative_error(drifting, reference, 10, Spacing::kFrames);
  const RelativeError there =
      relative_error(moved(drifting, {9.0, 9.0, 3.0}), reference, 10, Spacing::kFrames);
  EXPECT_NEAR(here.translation_m.mean, 0.01, 1e-4) << "ten steps of a millimetre";
  EXPECT_NEAR(here.translation_m.mean, there.translation_m.mean, 1e-9);
  EXPECT_EQ(here.pairs, 190);
}

TEST(RelativeError, SpacingsAgreeOnASteadyDrive) {
  Trajectory reference;
  Trajectory estimate;
  for (int i = 0; i <= 100; ++i) {
    reference.append(at(0.5 * i), {0.25 * i, 0.0, 0.0});
    estimate.append(at(0.5 * i), {0.26 * i, 0.0, 0.0});
  }
  // 4 frames = 2 s = 1 m: the estimate drives 4 cm too far.
  for (const auto& [delta, spacing] :
       {std::pair{4.0, Spacing::kFrames}, std::pair{2.0, Spacing::kSeconds},
        std::pair{1.0, Spacing::kMetres}}) {
    const RelativeError error = relative_error(estimate, reference, delta, spacing);
    EXPECT_EQ(error.pairs, 97);
    EXPECT_NEAR(error.translation_m.rmse, 0.04, 1e-9);
    EXPECT_NEAR(error.rotation_rad.max, 0.0, 1e-12);
  }
}

TEST(RelativeError, WithoutAPairIsEmpty) {
  const Trajectory path = winding_path(10);
  EXPECT_EQ(relative_error(path, path, 1000.0, Spacing::kMetres).pairs, 0);
  EXPECT_EQ(relative_error(Trajectory{}, path, 1.0, Spacing::kMetres).pairs, 0);
}

}  // namespace
}  // namespace loopstone
