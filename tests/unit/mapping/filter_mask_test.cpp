#include "loopstone/mapping/filter_mask.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace loopstone {
namespace {

const GridFrame kFrame{.origin = {0.0, 0.0}, .resolution = 0.5, .columns = 20, .rows = 12};

std::int8_t value_at(const FilterMask& mask, double x, double y) {
  return mask.values[mask.values.frame().cell_of({x, y})];
}

/// What nav2 makes of a value.
double meant(const FilterMask& mask, double x, double y) {
  return mask.base + mask.multiplier * value_at(mask, x, y);
}

TEST(FilterMask, NoZoneIsTooThinToKeepARobotOut) {
  const std::vector<KeepOutZone> zones{{"stairs", box_polygon({1.0, 1.0}, {3.0, 2.0})},
                                       {"tape", box_polygon({5.01, 0.0}, {5.02, 6.0})}};
  const FilterMask mask = keep_out_mask(kFrame, zones);
  EXPECT_EQ(mask.type, FilterType::kKeepOut);
  EXPECT_EQ(value_at(mask, 2.0, 1.5), 100);
  EXPECT_EQ(value_at(mask, 4.0, 1.5), 0);
  for (double y = 0.25; y < 6.0; y += 0.5) EXPECT_EQ(value_at(mask, 5.01, y), 100) << y;
}

TEST(FilterMask, PercentagesAreWrittenAsTheyAreAndTheSlowestHolds) {
  const std::vector<SpeedZone> zones{{"ramp", box_polygon({0.0, 0.0}, {4.0, 4.0}), 50.0},
                                     {"door", box_polygon({3.0, 0.0}, {6.0, 4.0}), 20.0}};
  const FilterMask mask = speed_mask(kFrame, zones);
  EXPECT_EQ(mask.type, FilterType::kSpeedPercent);
  EXPECT_EQ(meant(mask, 1.0, 1.0), 50.0);
  EXPECT_EQ(meant(mask, 3.5, 1.0), 20.0);
  EXPECT_EQ(meant(mask, 5.0, 1.0), 20.0);
  EXPECT_EQ(value_at(mask, 9.0, 5.0), 0);  // no limit
  std::vector<SpeedZone> other_way(zones.rbegin(), zones.rend());
  EXPECT_EQ(speed_mask(kFrame, other_way).values.cells(), mask.values.cells());
}

TEST(FilterMask, NoRobotGoesFasterThanTold) {
  for (const double limit : {0.001, 0.3, 0.55, 0.999, 1.0, 1.1, 2.0, 7.3, 49.0, 50.0, 1000.0}) {
    const std::vector<SpeedZone> zones{
        {"", box_polygon({0.0, 0.0}, {4.0, 4.0}), limit, SpeedUnit::kMetresPerSecond}};
    const FilterMask mask = speed_mask(kFrame, zones);
    EXPECT_EQ(mask.type, FilterType::kSpeedAbsolute);
    const double told = meant(mask, 1.0, 1.0);
    EXPECT_LE(told, limit * (1.0 + 1e-9));
    // In steps of a hundredth of at most two and a half times the limit.
    EXPECT_GT(told, limit * 0.97);
  }
}

TEST(FilterMask, ALimitFarBelowTheOthersStaysOne) {
  const std::vector<SpeedZone> zones{
      {"", box_polygon({0.0, 0.0}, {2.0, 2.0}), 0.001, SpeedUnit::kMetresPerSecond},
      {"", box_polygon({3.0, 3.0}, {5.0, 5.0}), 2.0, SpeedUnit::kMetresPerSecond}};
  const FilterMask mask = speed_mask(kFrame, zones);
  EXPECT_EQ(value_at(mask, 1.0, 1.0), 1);
  EXPECT_NEAR(meant(mask, 4.0, 4.0), 2.0, 1e-12);
}

}  // namespace
}  // namespace loopstone
