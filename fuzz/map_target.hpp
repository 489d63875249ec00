#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "loopstone/formats/ros_map.hpp"
#include "loopstone/localization/localizer.hpp"
#include "loopstone/registration/map_match.hpp"
#include "refusal.hpp"

// What every target does with a map that could be read.
namespace loopstone::fuzz {

/// Writes it, finds a scan on it and localises a robot that stands, when it is small.
inline void use_map(const CellStates& map) {
  constexpr std::size_t kMostCells = 10'000;
  if (map.frame().cell_count() > kMostCells) return;
  (void)map_image(map);
  (void)parse_map_yaml(format_map_yaml(map.frame(), "map.pgm"));
  if (!goes_on()) return;
  LaserScan scan{.angle_min_rad = -1.5,
                 .angle_increment_rad = 0.1,
                 .range_min_m = 0.1,
                 .range_max_m = 10.0,
                 .ranges_m = std::vector<float>(31, 0.4F)};
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 20; ++i) points.emplace_back(0.4, -0.5 + 0.05 * i);
  const MapSearch search(map);
  (void)match_on_map(points, search);
  (void)match_on_map(points, search, SearchWindow{{}, 0.5, 0.5});

  LocalizationOptions options;
  options.particles_max = 200;
  const LocalizationMap known(map);
  Localizer localizer(known, {}, options, InitialPose{}, 1, Threads{1});
  for (int i = 0; i < 3; ++i) {
    scan.stamp = Stamp{i * 100'000'000LL};
    localizer.add(OdometryPose{scan.stamp, {0.05 * i, 0.0, 0.0}});
    localizer.add(scan);
  }
  (void)localizer.finish();
}

}  // namespace loopstone::fuzz
