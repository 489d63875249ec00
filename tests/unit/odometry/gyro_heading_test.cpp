#include "loopstone/odometry/gyro_heading.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace loopstone {
namespace {

ImuSample sample_at(double seconds, double rate_rad_s) {
  ImuSample sample;
  sample.stamp = Stamp::from_seconds(seconds);
  sample.angular_velocity_rad_s = {0.0, 0.0, rate_rad_s};
  return sample;
}

TEST(GyroHeading, IntegratesALinearRateExactly) {
  GyroHeading gyro;
  for (int i = 0; i <= 200; ++i) gyro.add(sample_at(0.01 * i, 0.01 * i));  // rate = time
  const auto from = gyro.heading_at(Stamp::from_seconds(0.503));
  const auto to = gyro.heading_at(Stamp::from_seconds(1.507));
  ASSERT_TRUE(from && to);
  EXPECT_NEAR(*to - *from, 0.5 * (1.507 * 1.507 - 0.503 * 0.503), 1e-9);
  EXPECT_EQ(gyro.newest(), Stamp::from_seconds(2.0));
}

TEST(GyroHeading, SaysNothingOfTimesThatItDoesNotKnow) {
  GyroHeading gyro;
  EXPECT_FALSE(gyro.heading_at(Stamp::from_seconds(1.0)));
  for (int i = 0; i <= 2000; ++i) gyro.add(sample_at(10.0 + 0.01 * i, 1.0));
  EXPECT_FALSE(gyro.heading_at(Stamp::from_seconds(10.0))) << "forgotten";
  EXPECT_TRUE(gyro.heading_at(Stamp::from_seconds(25.0)));
  EXPECT_TRUE(gyro.heading_at(Stamp::from_seconds(30.04)));
  EXPECT_FALSE(gyro.heading_at(Stamp::from_seconds(30.1)));
}

TEST(GyroHeading, StartsAnewAfterAGapAndIgnoresNonsense) {
  GyroHeading gyro;
  gyro.add(sample_at(1.0, 0.5));
  gyro.add(sample_at(1.1, std::numeric_limits<double>::quiet_NaN()));
  gyro.add(sample_at(0.9, 5.0));
  EXPECT_EQ(gyro.newest(), Stamp::from_seconds(1.0));
  gyro.add(sample_at(3.0, 0.5));
  EXPECT_FALSE(gyro.heading_at(Stamp::from_seconds(2.0)));
  EXPECT_TRUE(gyro.heading_at(Stamp::from_seconds(3.0)));
}

}  // namespace
}  // namespace loopstone
