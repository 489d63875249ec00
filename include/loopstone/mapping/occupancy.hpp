#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "loopstone/base/options.hpp"
#include "loopstone/base/parallel_for.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/grid/grid.hpp"
#include "loopstone/sensor/laser_scan.hpp"

namespace loopstone {

/// How measurements become occupancy. Source: Moravec and Elfes 1985; Thrun, Burgard and Fox 2005,
/// table 9.1.
struct OccupancyOptions {
  double resolution_m = 0.05;
  double hit_probability = 0.7;
  double miss_probability = 0.4;
  double clamp_probability = 0.97;
  double no_return_carve_m = 5.0;
  double max_range_m = 80.0;
  /// What the machine may hold, no matter of taste. The default is 820 m x 820 m at 5 cm, and takes
  /// 2 GB with what is made of it.
  std::uint64_t most_cells = std::uint64_t{1} << 28U;
};

template <typename Visitor>
void visit_options(OccupancyOptions& options, Visitor&& visit) {
  visit("resolution_m", options.resolution_m, Range{0.005, 1.0}, "side of a map cell");
  visit("hit_probability", options.hit_probability, Range{0.5, 0.999},
        "belief that a cell is occupied where a beam ended");
  visit("miss_probability", options.miss_probability, Range{0.001, 0.5},
        "belief that a cell is occupied where a beam passed through");
  visit("clamp_probability", options.clamp_probability, Range{0.5, 0.9999},
        "belief stays within [1 - p, p], so that a map can change its mind");
  visit("no_return_carve_m", options.no_return_carve_m, Range{0.0, 200.0},
        "a beam without return frees cells up to this far");
  visit("max_range_m", options.max_range_m, Range{0.1, 1000.0},
        "returns beyond count as beams without return");
}

/// A scan and where its beams stood. With a sweep, the pose moves from `map_T_lidar` (first beam)
/// to `map_T_lidar_end` (last beam).
struct PosedScan {
  const LaserScan* scan = nullptr;
  Pose2 map_T_lidar;
  Pose2 map_T_lidar_end;
  Pose2 map_T_robot;
};

/// Log-odds occupancy: positive = occupied, negative = free, NaN-free; `observed` tells unknown
/// cells from even ones.
struct OccupancyMap {
  Grid<float> log_odds;         ///< 0 where never observed
  Grid<std::uint8_t> observed;  ///< 1 where a beam passed or ended, or the robot drove

  /// Probability of occupancy in [0, 1]; 0.5 where unknown.
  [[nodiscard]] double probability(Cell cell) const;
};

/// Builds the map of all scans at their poses; extent grows to what was seen. Where that is more
/// than `most_cells`, the cells are twice as wide, or four times, up to 1 m; throws UsageError when
/// that does not help either. Cells that the robot's footprint crossed are free. Within a scan an
/// end point wins over a pass-through, and each cell changes at most once. The same bytes for any
/// number of threads.
/// Cost: O(cells that beams cross).
[[nodiscard]] OccupancyMap build_occupancy_map(std::span<const PosedScan> scans,
                                               double footprint_radius_m,
                                               const OccupancyOptions& options = {},
                                               Threads threads = {});

/// Says so when the map's cells are wider than asked.
[[nodiscard]] std::optional<std::string> coarser_than_asked(const OccupancyMap& map,
                                                            const OccupancyOptions& options);

}  // namespace loopstone
