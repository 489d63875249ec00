#include "loopstone/mapping/filter_mask.hpp"

#include <algorithm>
#include <cmath>

#include "loopstone/mapping/map_touch_up.hpp"

namespace loopstone {

namespace {

constexpr std::int8_t kMostValue = 100;

/// 1, 2, 5, 10, 20, ... and so on, and below 1 in the same way: the first that is large enough.
double round_up(double limit) {
  double decade = std::pow(10.0, std::floor(std::log10(limit)));
  for (;; decade *= 10.0) {
    for (const double step : {1.0, 2.0, 5.0})
      if (step * decade >= limit) return step * decade;
  }
}

std::int8_t value_of(double limit, double multiplier) {
  // A limit that is a whole number of steps stays one, whatever the division's last bit.
  constexpr double kRounding = 1e-9;
  const double value = std::floor(limit / multiplier + kRounding);
  return static_cast<std::int8_t>(std::clamp(value, 1.0, static_cast<double>(kMostValue)));
}

}  // namespace

FilterMask keep_out_mask(const GridFrame& frame, std::span<const KeepOutZone> zones) {
  FilterMask mask{.values = Grid<std::int8_t>(frame), .type = FilterType::kKeepOut};
  for (const KeepOutZone& zone : zones) {
    for_each_cell_touching(zone.polygon, frame, [&](Cell cell) { mask.values[cell] = kMostValue; });
  }
  return mask;
}

FilterMask speed_mask(const GridFrame& frame, std::span<const SpeedZone> zones) {
  const bool in_percent = zones.front().unit == SpeedUnit::kPercent;
  FilterMask mask{.values = Grid<std::int8_t>(frame),
                  .type = in_percent ? FilterType::kSpeedPercent : FilterType::kSpeedAbsolute};
  if (!in_percent) {
    const auto fastest = std::ranges::max_element(zones, {}, &SpeedZone::limit);
    mask.multiplier = round_up(fastest->limit) / kMostValue;
  }
  for (const SpeedZone& zone : zones) {
    const std::int8_t value = value_of(zone.limit, mask.multiplier);
    for_each_cell_touching(zone.polygon, frame, [&](Cell cell) {
      std::int8_t& slowest = mask.values[cell];
      slowest = slowest == 0 ? value : std::min(slowest, value);
    });
  }
  return mask;
}

}  // namespace loopstone
