#include "loopstone/slam/scan_queue.hpp"

#include <gtest/gtest.h>

namespace loopstone {
namespace {

LaserScan scan_at(double seconds) {
  LaserScan scan;
  scan.stamp = Stamp::from_seconds(seconds);
  return scan;
}

OdometryPose pose_at(double seconds) {
  return {Stamp::from_seconds(seconds), Pose2{seconds, 0.0, 0.0}};
}

TEST(ScanQueue, HoldsAScanBackUntilOdometryHasReachedIt) {
  ScanQueue queue(WheelModel{});
  queue.add(pose_at(0.0));
  queue.add(scan_at(0.1));
  EXPECT_FALSE(queue.next().has_value());
  queue.add(pose_at(0.2));
  const auto scan = queue.next();
  ASSERT_TRUE(scan.has_value());
  EXPECT_EQ(scan->stamp, Stamp::from_seconds(0.1));
  const auto pose = queue.odometer().pose_at(scan->stamp);
  ASSERT_TRUE(pose.has_value());
  EXPECT_NEAR(pose->pose.x, 0.1, 1e-9) << "between the poses, not beyond the first";
  EXPECT_FALSE(queue.next().has_value());
}

TEST(ScanQueue, AScanWithOdometryOfItsOwnStampGoesAtOnce) {
  ScanQueue queue(WheelModel{});
  queue.add(pose_at(0.1));
  queue.add(scan_at(0.1));
  EXPECT_TRUE(queue.next().has_value());
}

TEST(ScanQueue, WaitsNoLongerThanAQuarterOfASecond) {
  ScanQueue queue(WheelModel{});
  queue.add(scan_at(0.0));
  queue.add(scan_at(0.2));
  EXPECT_FALSE(queue.next().has_value());
  queue.add(scan_at(0.25));
  const auto first = queue.next();
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(first->stamp, Stamp::from_seconds(0.0));
  EXPECT_FALSE(queue.next().has_value());
}

TEST(ScanQueue, GivesOutWhatIsLeftInOrderAtTheEnd) {
  ScanQueue queue(WheelModel{});
  queue.add(scan_at(0.0));
  queue.add(scan_at(0.1));
  queue.finish();
  EXPECT_EQ(queue.next()->stamp, Stamp::from_seconds(0.0));
  EXPECT_EQ(queue.next()->stamp, Stamp::from_seconds(0.1));
  EXPECT_FALSE(queue.next().has_value());
}

}  // namespace
}  // namespace loopstone
