#include "loopstone/slam/laser_check.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace loopstone {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

LaserScan scan_of(double seconds, std::vector<float> ranges_m) {
  LaserScan scan;
  scan.stamp = Stamp::from_seconds(seconds);
  scan.ranges_m = std::move(ranges_m);
  return scan;
}

std::vector<float> wall(float shift_m) {
  std::vector<float> ranges_m;
  for (int i = 0; i < 100; ++i) ranges_m.push_back(2.0F + shift_m + 0.01F * static_cast<float>(i));
  return ranges_m;
}

OdometryReading at(double x_m) { return {.odom_T_robot = {x_m, 0.0, 0.0}, .path_m = x_m}; }

TEST(LaserCheck, BelievesScansThatChange) {
  LaserCheck check;
  for (int i = 0; i < 50; ++i)
    EXPECT_TRUE(check.add(scan_of(0.1 * i, wall(0.01F * static_cast<float>(i))), at(0.1 * i)));
  EXPECT_TRUE(check.episodes().empty());
  EXPECT_EQ(check.most_repeated(), 0U);
}

TEST(LaserCheck, ARobotThatStandsMayRepeatItself) {
  LaserCheck check;
  for (int i = 0; i < 50; ++i) EXPECT_TRUE(check.add(scan_of(0.1 * i, wall(0.0F)), at(1.0)));
  EXPECT_TRUE(check.episodes().empty());
}

TEST(LaserCheck, ARobotThatDrivesMayNot) {
  LaserCheck check;
  for (int i = 0; i <= 50; ++i) {
    const bool moving = i >= 10;
    const bool believed = check.add(
        scan_of(0.1 * i, wall(moving ? 0.0F : 0.01F * static_cast<float>(i))), at(0.1 * i));
    // One step of 10 cm shows it.
    EXPECT_EQ(believed, i <= 10) << i;
  }
  ASSERT_EQ(check.episodes().size(), 1U);
  const LaserEpisode& episode = check.episodes().front();
  EXPECT_EQ(episode.fault, LaserFault::kFrozen);
  EXPECT_EQ(episode.from, Stamp::from_seconds(1.1));
  EXPECT_EQ(episode.to, Stamp::from_seconds(5.0));
  EXPECT_EQ(episode.scans, 40U);
  EXPECT_NEAR(episode.odometry_m, 4.0, 1e-9);
}

TEST(LaserCheck, WithoutOdometryRepetitionIsCountedOnly) {
  LaserCheck check;
  for (int i = 0; i < 50; ++i) EXPECT_TRUE(check.add(scan_of(0.1 * i, wall(0.0F)), {}));
  EXPECT_TRUE(check.episodes().empty());
  EXPECT_EQ(check.most_repeated(), 49U);
}

TEST(LaserCheck, ARingRightInFrontOfTheLaserIsItsCover) {
  LaserCheck check;
  for (int i = 0; i < 30; ++i) {
    std::vector<float> ring(100, 0.1F + 0.001F * static_cast<float>(i));
    std::fill(ring.begin(), ring.begin() + 15, 3.0F);
    EXPECT_EQ(
        check.add(scan_of(0.1 * i, i < 10 || i >= 20 ? wall(0.1F * static_cast<float>(i)) : ring),
                  at(0.1 * i)),
        i < 10 || i >= 20)
        << i;
  }
  ASSERT_EQ(check.episodes().size(), 1U);
  EXPECT_EQ(check.episodes().front().fault, LaserFault::kBlocked);
  EXPECT_EQ(check.episodes().front().scans, 10U);
}

TEST(LaserCheck, NarrowPlacesAndEmptyScansAreNoFault) {
  LaserCheck check;
  std::vector<float> narrow(100, 0.3F);
  std::fill(narrow.begin() + 60, narrow.end(), 1.0F);
  EXPECT_TRUE(check.add(scan_of(0.0, narrow), at(0.0)));
  for (int i = 1; i < 20; ++i)
    EXPECT_TRUE(check.add(scan_of(0.1 * i, std::vector<float>(100, kInf)), at(0.5 * i)));
  EXPECT_TRUE(check.add(scan_of(3.0, {0.1F, 0.1F}), at(0.0))) << "two returns say nothing";
  EXPECT_TRUE(check.add(scan_of(3.1, {}), at(0.0)));
}

}  // namespace
}  // namespace loopstone
