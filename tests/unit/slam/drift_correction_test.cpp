#include "slam/drift_correction.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using test::pose_near;

Stamp second(double s) { return {static_cast<std::int64_t>(s * 1e9)}; }

/// Key scans 10 and 20 of a straight drive of 1 m a scan and 1 s; the second one was moved.
const std::vector<KeyScan> kKeys{
    {.stamp = second(10.0), .local_T_robot = {10.0, 0.0, 0.0}, .scan = 10},
    {.stamp = second(20.0), .local_T_robot = {20.0, 0.0, 0.0}, .scan = 20}};
const std::vector<Pose2> kSolved{{10.0, 1.0, 0.0}, {20.0, 3.0, 0.0}};

TEST(DriftCorrection, KeyScansLieWhereTheyWereSolved) {
  const DriftCorrection correction(kKeys, kSolved);
  for (std::size_t i = 0; i < kKeys.size(); ++i) {
    const Pose2& local = kKeys[i].local_T_robot;
    EXPECT_TRUE(pose_near(correction.at(kKeys[i].scan, kKeys[i].stamp, local) * local, kSolved[i],
                          1e-12, 1e-12));
  }
}

TEST(DriftCorrection, BlendsByTimeBetweenThem) {
  const DriftCorrection correction(kKeys, kSolved);
  const Pose2 local{14.0, 0.0, 0.0};
  EXPECT_TRUE(
      pose_near(correction.at(14, second(14.0), local) * local, {14.0, 1.8, 0.0}, 1e-9, 1e-9));
}

TEST(DriftCorrection, WherePathsBreakItChangesDuringTheBreakAlone) {
  std::vector<KeyScan> keys = kKeys;
  keys[1].across = Eigen::Matrix3d::Identity();
  const std::vector<PathBreak> breaks{{.from = second(16.0), .to = second(18.0)}};
  const DriftCorrection correction(keys, kSolved, breaks);
  const auto moved_m = [&](double at_s) {
    const Pose2 local{at_s, 0.0, 0.0};
    return (correction.at(static_cast<std::size_t>(at_s), second(at_s), local) * local).y;
  };
  EXPECT_DOUBLE_EQ(moved_m(12.0), 1.0);
  EXPECT_DOUBLE_EQ(moved_m(16.0), 1.0);
  // Scans that nothing held rode on odometry.
  EXPECT_NEAR(moved_m(17.0), 2.0, 1e-9);
  EXPECT_DOUBLE_EQ(moved_m(18.0), 3.0);
  EXPECT_DOUBLE_EQ(moved_m(19.0), 3.0);
}

TEST(DriftCorrection, ABreakThatTheLaserBridgedChangesNothing) {
  const std::vector<PathBreak> breaks{{.from = second(16.0), .to = second(18.0)}};
  const DriftCorrection correction(kKeys, kSolved, breaks);
  const Pose2 local{14.0, 0.0, 0.0};
  EXPECT_TRUE(
      pose_near(correction.at(14, second(14.0), local) * local, {14.0, 1.8, 0.0}, 1e-9, 1e-9));
}

TEST(DriftCorrection, HoldsBeforeTheFirstAndAfterTheLast) {
  const DriftCorrection correction(kKeys, kSolved);
  const Pose2 early{2.0, 0.5, 0.0};
  EXPECT_TRUE(
      pose_near(correction.at(2, second(2.0), early) * early, {2.0, 1.5, 0.0}, 1e-12, 1e-12));
  const Pose2 late{25.0, 0.0, 0.0};
  EXPECT_TRUE(
      pose_near(correction.at(25, second(25.0), late) * late, {25.0, 3.0, 0.0}, 1e-12, 1e-12));
  EXPECT_EQ(DriftCorrection({}, {}).at(0, second(0.0), early), Pose2{});
}

}  // namespace
}  // namespace loopstone
