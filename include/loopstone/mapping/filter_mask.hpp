#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "loopstone/base/words.hpp"
#include "loopstone/geometry/polygon.hpp"
#include "loopstone/grid/grid.hpp"

// Zones of a map as nav2's costmap filters read them: an occupancy grid beside the map, whose
// values are turned into what they mean by `base + multiplier * value`.
// Source: docs.nav2.org, "Costmap Filter Info Server", "Keepout Filter", "Speed Filter".

namespace loopstone {

/// Where a robot must not go.
struct KeepOutZone {
  std::string name{};
  Polygon2 polygon{};
};

/// How a speed is told.
enum class SpeedUnit {
  kPercent,  ///< of the robot's largest
  kMetresPerSecond,
};

/// Where a robot must not go faster.
struct SpeedZone {
  std::string name{};
  Polygon2 polygon{};
  double limit = 0.0;  ///< (0, 100] %, or above 0 m/s
  SpeedUnit unit = SpeedUnit::kPercent;
};

/// CostmapFilterInfo's types.
enum class FilterType { kKeepOut = 0, kSpeedPercent = 1, kSpeedAbsolute = 2 };

/// A mask and how its values are to be read.
struct FilterMask {
  Grid<std::int8_t> values{};  ///< 0: nothing holds here; 1 to 100
  FilterType type = FilterType::kKeepOut;
  double base = 0.0;
  double multiplier = 1.0;
};

/// 100 (lethal) in every cell that a zone touches, so that no zone is too thin to be seen.
[[nodiscard]] FilterMask keep_out_mask(const GridFrame& frame, std::span<const KeepOutZone> zones);

/// The limit in every cell that a zone touches; where zones overlap the slowest. Limits in m/s are
/// told in hundredths of the smallest of 1, 2, 5, 10, ... m/s that no limit exceeds, rounded down
/// so that no robot goes faster than told, and not to 0, which would be no limit.
/// \param zones  one at least, all of one unit
[[nodiscard]] FilterMask speed_mask(const GridFrame& frame, std::span<const SpeedZone> zones);

}  // namespace loopstone
