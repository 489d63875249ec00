// Wheels that are told one by one become readings of all.

#include "formats/wheel_sums.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace loopstone {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

constexpr WheelSpot kLeft{true, WheelRow::kOnly};
constexpr WheelSpot kRight{false, WheelRow::kOnly};

Stamp at(double seconds) { return Stamp::from_seconds(1000.0 + seconds); }

TEST(WheelSums, ReadingsAreOfAllWheelsAtTheTimesOfTheFirst) {
  WheelSums sums({kLeft, kRight});
  std::vector<WheelTicks> readings;
  const auto take = [&] {
    for (const WheelTicks& reading : sums.take()) readings.push_back(reading);
  };
  // The right wheel is told 30 ms after the left one, at the same 100 counts a second.
  for (int i = 0; i < 50; ++i) {
    sums.add(0, at(0.1 * i), 10.0 * i);
    take();
    sums.add(1, at(0.1 * i + 0.03), 10.0 * i + 3.0);
    take();
  }
  ASSERT_THAT(readings, SizeIs(49));  // of the first nobody knows where the right wheel was
  EXPECT_EQ(readings.front().stamp, at(0.1));
  EXPECT_THAT(readings.front().counts, Each(0));
  for (std::size_t i = 1; i < readings.size(); ++i) EXPECT_THAT(readings[i].counts, Each(10));
}

TEST(WheelSums, FractionsAreNotLost) {
  WheelSums sums({kLeft, kRight});
  std::int64_t left = 0;
  std::int64_t right = 0;
  for (int i = 0; i <= 1000; ++i) {
    sums.add(0, at(0.1 * i), 0.3 * i);
    sums.add(1, at(0.1 * i), -0.7 * i);
    for (const WheelTicks& reading : sums.take()) {
      left += reading.counts[1];
      right += reading.counts[0];
      EXPECT_EQ(reading.counts[3], reading.counts[1]) << "a side without rows counts for both";
    }
  }
  EXPECT_EQ(left, 300);
  EXPECT_EQ(right, -700);
}

TEST(WheelSums, RowsKeepTheirPlaces) {
  WheelSums sums({{false, WheelRow::kRear},
                  {true, WheelRow::kFront},
                  {true, WheelRow::kRear},
                  {false, WheelRow::kFront}});
  for (int i = 0; i < 2; ++i) {
    for (std::size_t wheel = 0; wheel < 4; ++wheel) {
      sums.add(wheel, at(i), 100.0 * i * static_cast<double>(wheel + 1));
    }
  }
  const auto readings = sums.take();
  ASSERT_THAT(readings, SizeIs(2));
  EXPECT_THAT(readings[1].counts, ElementsAre(400, 200, 100, 300));
}

TEST(WheelSums, ASilentWheelEndsTheReadingsAndFillsNoMemory) {
  WheelSums sums({kLeft, kRight});
  sums.add(1, at(0.0), 0.0);
  for (int i = 0; i < 100'000; ++i) sums.add(0, at(0.01 * i), i);
  EXPECT_THAT(sums.take(), SizeIs(0));
  sums.add(1, at(1000.0), 0.0);
  EXPECT_THAT(sums.take(), SizeIs(WheelSums::kMostWaiting));
  sums.add(0, at(0.5), 1.0);  // late
  EXPECT_THAT(sums.take(), IsEmpty());
}

}  // namespace
}  // namespace loopstone
