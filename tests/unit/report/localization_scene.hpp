#pragma once

#include <cmath>
#include <cstdint>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/grid/grid.hpp"
#include "loopstone/report/localization_outputs.hpp"

namespace loopstone::test {

/// A room of 12 m by 8 m with walls, unknown around it.
inline Grid<std::int8_t> small_room() {
  const GridFrame frame{.origin = {-1.0, -1.0}, .resolution = 0.1, .columns = 140, .rows = 100};
  Grid<std::int8_t> map(frame, -1);
  for (int row = 10; row <= 90; ++row) {
    for (int column = 10; column <= 130; ++column) {
      const bool wall = row == 10 || row == 90 || column == 10 || column == 130;
      map[{column, row}] = wall ? 100 : 0;
    }
  }
  return map;
}

/// Lost for 2 s, doubtful for 1 s, then tracking, with a short loss in between: 20 s along a line
/// of 10 m.
inline LocalizationResult small_localization() {
  LocalizationResult result;
  const Stamp start{1'500'000'000'000'000'000};
  for (int i = 0; i <= 200; ++i) {
    LocalizationEstimate e;
    e.stamp = start + Duration{100'000'000LL * i};
    const bool lost = i < 20 || (i >= 100 && i < 104);
    e.state = lost     ? LocalizationState::kLost
              : i < 30 ? LocalizationState::kDoubtful
                       : LocalizationState::kTracking;
    e.map_T_robot = {1.0 + 0.05 * i, i < 20 ? 6.5 : 2.0, 0.01 * i};
    const double sigma = lost ? 1.0 : 0.01;
    e.covariance.diagonal() << sigma * sigma, sigma * sigma, 0.01 * sigma;
    e.probability = lost ? 0.05 : i < 30 ? 0.5 : 0.97;
    e.refined = !lost;
    e.hypotheses = lost ? 3 : 1;
    e.particles = lost ? 400 : 100;
    e.travelled_m = 0.05 * i;
    e.evidence = {.explained = lost ? 0.3 : 0.95,
                  .violations = lost ? 0.4 : 0.01,
                  .unexpected = 0.02,
                  .mass = 0.9,
                  .spread_m = 2.0 * sigma,
                  .spread_rad = sigma,
                  .innovation = 1.0,
                  .followed_m = 0.05 * i};
    if (result.estimates.empty() || result.estimates.back().state != e.state)
      result.changes.push_back({e.stamp, e.state});
    result.estimates.push_back(e);
    if (i % 40 != 0) continue;
    BeliefSnapshot snapshot{.stamp = e.stamp, .estimate = e};
    for (int k = 0; k < e.particles; ++k) {
      const double angle = 2.4 * k;
      const double far = sigma * std::sqrt(k / 40.0);
      snapshot.particles.push_back({e.map_T_robot.x + far * std::cos(angle),
                                    e.map_T_robot.y + far * std::sin(angle), angle});
    }
    for (int k = 0; k < e.hypotheses; ++k)
      snapshot.hypotheses.push_back(
          {{e.map_T_robot.x + 4.0 * k, e.map_T_robot.y - k, 0.0}, 0.5 / (k + 1)});
    for (int k = 0; k < 60; ++k)
      snapshot.points.emplace_back(2.0F * std::cos(0.1F * k), 2.0F * std::sin(0.1F * k));
    result.snapshots.push_back(snapshot);
  }
  result.searches = {{start, "start", true, 7, 7, 0.91},
                     {start + Duration::from_seconds(10.1), "lost <again>", false, 2, 1, 0.83}};
  result.start = start;
  result.scans = 201;
  result.path_length_m = 10.0;
  result.duration_s = 20.0;
  result.search_s = 0.02;
  result.filter_s = 0.1;
  result.had_odometry = true;
  result.warnings = {"a wall <went> & came back"};
  return result;
}

inline LocalizationRunInfo small_run() {
  LocalizationRunInfo info;
  info.run.log_path = "/logs/a&b.clf";
  info.run.command_line = "loopstone localize a&b.clf --map m";
  info.run.options_toml = "particles_max = 2000  # <most>\n";
  info.run.version = "9.8.7";
  info.run.wall_time_s = 0.5;
  info.run.cpu_time_s = 0.75;
  info.run.peak_memory_bytes = 123'456'789'012;  // more than any test takes
  info.run.left_out.skipped.records = 4;
  info.map_path = "rooms/map.yaml";
  info.seed = 7;
  info.map_free_area_m2 = 96.0;
  return info;
}

}  // namespace loopstone::test
