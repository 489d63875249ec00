#include "loopstone/odometry/scan_queue.hpp"

#include <gtest/gtest.h>

#include <vector>

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

TEST(ScanQueue, AStreamThatBeginsWithoutOdometryIsNotWaitedForUntilSomeComes) {
  ScanQueue queue(WheelModel{});
  const auto out = [&] {
    int count = 0;
    while (queue.next()) ++count;
    return count;
  };
  for (double seconds = 0.0; seconds < 1.05; seconds += 0.1) queue.add(scan_at(seconds));
  EXPECT_EQ(out(), 8) << "up to 0.25 s before the newest";
  queue.add(scan_at(1.1));
  EXPECT_EQ(out(), 4) << "it has none";
  queue.add(scan_at(1.2));
  EXPECT_EQ(out(), 1);
  queue.add(pose_at(1.25));
  queue.add(scan_at(1.3));
  EXPECT_EQ(out(), 0) << "now it has";
  queue.add(pose_at(1.35));
  EXPECT_EQ(out(), 1);
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

/// Where odometry puts the robot at each scan, ten a second for 20 s; it drives 1 m/s. Odometry is
/// late by so much, and is shifted after 5 s.
std::vector<double> positions(double late_s, double shift_s) {
  ScanQueue queue(WheelModel{});
  std::vector<double> positions;
  for (int i = 0; i <= 200; ++i) {
    const double now = 0.1 * i;
    if (i == 50) {
      EXPECT_TRUE(queue.shift_odometry(Duration::from_seconds(shift_s)));
      EXPECT_TRUE(queue.is_shifting());
    }
    queue.add(OdometryPose{Stamp::from_seconds(now), Pose2{now - late_s, 0.0, 0.0}});
    queue.add(scan_at(now));
    while (const auto scan = queue.next()) {
      EXPECT_EQ(scan->stamp, Stamp::from_seconds(0.1 * static_cast<double>(positions.size())));
      positions.push_back(queue.reading_at(scan->stamp)->odom_T_robot.x);
    }
  }
  EXPECT_FALSE(queue.is_shifting());
  return positions;
}

TEST(ScanQueue, OdometryThatIsLateIsReadLaterStepByStep) {
  for (const double late_s : {0.4, -0.3, 0.0}) {
    const auto found = positions(late_s, late_s == 0.0 ? 0.2 : late_s);
    const double left_s = late_s == 0.0 ? -0.2 : 0.0;
    ASSERT_GT(found.size(), 190U);
    for (std::size_t i = 1; i < found.size(); ++i)
      EXPECT_NEAR(found[i] - found[i - 1], 0.1, 0.0101) << "a tenth more or less at most";
    EXPECT_NEAR(found[40], 4.0 - late_s, 1e-6);
    EXPECT_NEAR(found[190], 19.0 - left_s, 1e-6);
  }
}

TEST(ScanQueue, ClocksThatAreTooFarApartAreLeftAlone) {
  ScanQueue queue(WheelModel{});
  EXPECT_TRUE(queue.shift_odometry(Duration::from_seconds(7.0)));
  EXPECT_FALSE(queue.shift_odometry(Duration::from_seconds(2.0)));
  EXPECT_TRUE(queue.shift_odometry(Duration::from_seconds(-7.0)));
  EXPECT_FALSE(queue.is_shifting());
}

TEST(ScanQueue, TellsThePathAndWhenOdometryWasSilent) {
  ScanQueue queue(WheelModel{});
  const auto reading = [&](double seconds) {
    queue.add(pose_at(seconds));
    queue.add(scan_at(seconds));
    return queue.reading_at(queue.next().value().stamp).value();
  };
  EXPECT_EQ(reading(0.0).path_m, 0.0);
  EXPECT_NEAR(reading(0.5).path_m, 0.5, 1e-9);
  queue.add(OdometryPose{Stamp::from_seconds(1.0), Pose2{0.0, 0.0, 0.5}});
  const OdometryReading back = reading(1.5);
  EXPECT_NEAR(back.path_m, 0.5 + 0.5 + 1.5, 1e-9) << "there and back is a way too";
  EXPECT_NEAR(back.turned_rad, 1.0, 1e-9);
  EXPECT_FALSE(reading(10.0).silent_until) << "poses go on where they were";
  const OdometryReading after = reading(200.0);
  ASSERT_TRUE(after.silent_until);
  EXPECT_EQ(*after.silent_until, Stamp::from_seconds(200.0));
}

/// Of wheels that count since the last reading, 40 a second but for a silence after 3 s.
std::optional<Stamp> silent_after(double silence_s, bool counts_are_cumulative) {
  WheelModel wheels;
  wheels.counts_are_cumulative = counts_are_cumulative;
  ScanQueue queue(wheels);
  std::int64_t sum = 0;
  const auto count = [&](double seconds) {
    sum += 8;
    const std::int64_t counts = counts_are_cumulative ? sum : 8;
    queue.add(WheelTicks{Stamp::from_seconds(seconds), {counts, counts, counts, counts}});
  };
  double seconds = 0.0;
  for (; seconds < 3.0; seconds += 0.025) count(seconds);
  seconds += silence_s;
  const double end = seconds + 0.5;
  for (; seconds < end; seconds += 0.025) count(seconds);
  queue.add(scan_at(end - 0.05));
  return queue.reading_at(queue.next().value().stamp).value().silent_until;
}

TEST(ScanQueue, CountsSinceTheLastReadingAreMissedSoonerThanCounters) {
  EXPECT_FALSE(silent_after(0.15, false)) << "a stamp may be late";
  const auto until = silent_after(0.5, false);
  ASSERT_TRUE(until);
  EXPECT_NEAR(until->seconds(), 3.5, 0.03);
  EXPECT_FALSE(silent_after(0.5, true)) << "counters went on";
}

}  // namespace
}  // namespace loopstone
