// How long correlative search takes: windows around a guess on scans of a building, with and
// without the grid it searches, and matching on the map of the same building.

#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/registration/correlative_match.hpp"
#include "loopstone/registration/correlative_search.hpp"
#include "loopstone/registration/field_match.hpp"
#include "loopstone/registration/map_match.hpp"
#include "loopstone/sensor/scan_points.hpp"
#include "loopstone/simulation/surface_index.hpp"
#include "loopstone/simulation/world.hpp"
#include "registration_pairs.hpp"

namespace loopstone {
namespace {

using Points = std::vector<Eigen::Vector2d>;

struct Pair {
  Points target;
  Points source;
  Pose2 map_T_source;
};

struct Building {
  World world = make_world("office", 1);
  SurfaceIndex surfaces{world.plan};
  Grid<std::int8_t> map = true_map(world, 0.05);
  std::vector<Pair> pairs;

  Building() {
    Rng rng(5);
    while (pairs.size() < 20) {
      const Cell cell{static_cast<int>(rng.below(static_cast<std::uint64_t>(map.frame().columns))),
                      static_cast<int>(rng.below(static_cast<std::uint64_t>(map.frame().rows)))};
      const Eigen::Vector2d at = map.frame().centre_of(cell);
      if (map[cell] != 0 || surfaces.distance(at, 1.0) < 0.8) continue;
      const Pose2 first{at.x(), at.y(), rng.uniform(-kPi, kPi)};
      const Pose2 second =
          first * Pose2{rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3)};
      pairs.push_back({scan_at(first, rng), scan_at(second, rng), second});
    }
  }

  [[nodiscard]] Points scan_at(const Pose2& map_T_laser, Rng& rng) const {
    return scan_points(bench::cast_scan(surfaces, map_T_laser, bench::kSensor1081, rng), Pose2{});
  }
};

const Building& building() {
  static const Building office;
  return office;
}

/// Returns at least so far apart; 0: all of them.
Points thinned(const Points& points, double spacing_m) {
  Points kept;
  for (const auto& point : points) {
    if (kept.empty() || (point - kept.back()).norm() >= spacing_m) kept.push_back(point);
  }
  return kept;
}

/// Arguments: half side [cm], half angle [deg], spacing of the source's points [mm].
void window(benchmark::State& state, bool with_grid) {
  const double half_xy_m = 0.01 * static_cast<double>(state.range(0));
  const double half_yaw_rad = radians(static_cast<double>(state.range(1)));
  const double spacing_m = 0.001 * static_cast<double>(state.range(2));
  std::vector<Points> sources;
  std::vector<MaxPyramid> targets;
  double points = 0.0;
  for (const Pair& pair : building().pairs) {
    sources.push_back(thinned(pair.source, spacing_m));
    targets.push_back(make_correlative_target(pair.target, half_xy_m));
    points += static_cast<double>(sources.back().size());
  }
  std::size_t next = 0;
  double evaluations = 0.0;
  for (auto _ : state) {
    const std::size_t i = next++ % sources.size();
    SearchResult result;
    if (with_grid) {
      const MaxPyramid target = make_correlative_target(building().pairs[i].target, half_xy_m);
      result = search_branch_and_bound(sources[i], target, {{}, half_xy_m, half_yaw_rad}, 0.2);
    } else {
      result = search_branch_and_bound(sources[i], targets[i], {{}, half_xy_m, half_yaw_rad}, 0.2);
    }
    evaluations += static_cast<double>(result.evaluations);
  }
  state.counters["points"] = points / static_cast<double>(sources.size());
  state.counters["evaluations"] = evaluations / static_cast<double>(next);
}
void search_window(benchmark::State& state) { window(state, false); }
void search_window_with_grid(benchmark::State& state) { window(state, true); }
BENCHMARK(search_window)
    ->Args({50, 20, 50})
    ->Args({50, 20, 0})
    ->Args({400, 90, 50})
    ->Args({400, 90, 0})
    ->Unit(benchmark::kMillisecond);
BENCHMARK(search_window_with_grid)
    ->Args({50, 20, 50})
    ->Args({400, 90, 50})
    ->Unit(benchmark::kMillisecond);

void match_window(benchmark::State& state) {
  std::size_t next = 0;
  for (auto _ : state) {
    const Pair& pair = building().pairs[next++ % building().pairs.size()];
    const auto target = make_correlative_target(pair.target, 0.5);
    benchmark::DoNotOptimize(
        match_correlative(thinned(pair.source, 0.05), target, {{}, 0.5, radians(20.0)}));
  }
}
BENCHMARK(match_window)->Unit(benchmark::kMillisecond);

void match_field_near(benchmark::State& state) {
  const MapField field(building().map);
  std::size_t next = 0;
  for (auto _ : state) {
    const Pair& pair = building().pairs[next++ % building().pairs.size()];
    benchmark::DoNotOptimize(
        match_to_field(pair.source, field, pair.map_T_source * Pose2{0.1, -0.1, 0.05}));
  }
}
BENCHMARK(match_field_near)->Unit(benchmark::kMillisecond);

void build_map_search(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(MapSearch(building().map));
  state.counters["cells"] = static_cast<double>(building().map.cells().size());
}
BENCHMARK(build_map_search)->Unit(benchmark::kMillisecond);

void match_map_without_guess(benchmark::State& state) {
  const MapSearch search(building().map);
  std::size_t next = 0;
  for (auto _ : state) {
    const Pair& pair = building().pairs[next++ % building().pairs.size()];
    benchmark::DoNotOptimize(match_on_map(pair.source, search));
  }
}
BENCHMARK(match_map_without_guess)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace loopstone
