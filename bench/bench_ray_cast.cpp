// How many rays a second each caster casts on one core, what it weighs, how long it takes to build,
// how far the table is from exact, and what the beam model costs on top.
//   bench_ray_cast [MAP.png] 5 cm cells, white is free, black is occupied; without a map, a
//   simulated office

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory_resource>
#include <string>
#include <vector>

#include "large_pages.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/grid/ray_cast.hpp"
#include "loopstone/localization/beam_model.hpp"
#include "loopstone/simulation/world.hpp"

namespace loopstone {
namespace {

constexpr double kMaxRangeM = 30.0;
constexpr double kFieldOfViewRad = 1.5 * kPi;

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Place {
  Grid<std::uint8_t> occupied{};
  Grid<std::uint8_t> free{};  ///< where rays start
  std::vector<Cell> free_cells{};

  void set(Cell cell, bool is_occupied, bool is_free) {
    occupied[cell] = is_occupied ? 1 : 0;
    free[cell] = is_free ? 1 : 0;
    if (is_free) free_cells.push_back(cell);
  }
  explicit Place(const GridFrame& frame) : occupied(frame), free(frame) {}
};

Place place_of(const Image& image) {
  Place place(GridFrame{.origin = {0.0, 0.0}, .columns = image.width, .rows = image.height});
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      const int value = image.sample(image.height - 1 - row, column);
      place.set({column, row}, value<100, value> 250);
    }
  }
  return place;
}

Place office() {
  const Grid<std::int8_t> map = true_map(make_world("office", 1), 0.05);
  Place place(map.frame());
  for (int row = 0; row < map.frame().rows; ++row) {
    for (int column = 0; column < map.frame().columns; ++column) {
      const Cell cell{column, row};
      place.set(cell, map[cell] >= 65, map[cell] == 0);
    }
  }
  return place;
}

/// Everything that the measurements share.
struct Setting {
  Place place;
  std::vector<Ray> rays{};     ///< from anywhere in free space, anywhere
  std::vector<Pose2> poses{};  ///< anywhere in free space

  explicit Setting(Place where) : place(std::move(where)) {
    Rng rng(1);
    for (int i = 0; i < 1'000'000; ++i) rays.push_back(ray_along(free_pose(rng)));
    for (int i = 0; i < 16'000; ++i) poses.push_back(free_pose(rng));
  }
  [[nodiscard]] Pose2 free_pose(Rng& rng) const {
    const Cell cell = place.free_cells[rng.below(place.free_cells.size())];
    const GridFrame& frame = place.free.frame();
    return {frame.origin.x() + (cell.column + rng.uniform()) * frame.resolution,
            frame.origin.y() + (cell.row + rng.uniform()) * frame.resolution,
            rng.uniform(-kPi, kPi)};
  }
};

std::vector<double> beam_angles(std::size_t beams) {
  std::vector<double> angles_rad;
  for (std::size_t k = 0; k < beams; ++k) {
    angles_rad.push_back(kFieldOfViewRad *
                         (static_cast<double>(k) / static_cast<double>(beams - 1) - 0.5));
  }
  return angles_rad;
}

struct Built {
  std::string name;
  RayCaster caster;
  double build_s;
};

template <typename Make>
Built build(const std::string& name, Make&& make) {
  const double before = cpu_seconds();
  RayCaster caster = make();
  return {name, std::move(caster), cpu_seconds() - before};
}

std::vector<Built> casters_of(const Place& place) {
  std::vector<Built> casters;
  casters.push_back(build("walk", [&] { return WalkCaster(place.occupied, kMaxRangeM); }));
  casters.push_back(
      build("sphere", [&] { return SphereCaster(place.occupied, kMaxRangeM, Threads{1}); }));
  static bench::LargePages large_pages;
  for (const int headings : {128, 384}) {
    for (std::pmr::memory_resource* memory :
         {std::pmr::get_default_resource(),
          static_cast<std::pmr::memory_resource*>(&large_pages)}) {
      const std::string pages = memory == &large_pages ? "large" : "";
      casters.push_back(build("table" + std::to_string(headings) + pages, [&] {
        return TableCaster(place.occupied, kMaxRangeM, place.free, {.headings = headings},
                           Threads{1}, memory);
      }));
    }
  }
  return casters;
}

void state_caster(benchmark::State& state, const Built& built) {
  state.counters["memory_bytes"] = static_cast<double>(built.caster.memory_bytes());
  state.counters["build_s"] = built.build_s;
}

void count_rays(benchmark::State& state, std::size_t rays) {
  state.counters["rays_per_s"] =
      benchmark::Counter(static_cast<double>(rays), benchmark::Counter::kIsIterationInvariantRate);
}

void cast_rays(benchmark::State& state, const Setting& setting, const Built& built) {
  std::vector<float> ranges_m(setting.rays.size());
  for (auto _ : state) built.caster.ranges(setting.rays, ranges_m);
  count_rays(state, ranges_m.size());
  state_caster(state, built);
}

void cast_scans(benchmark::State& state, const Setting& setting, const Built& built,
                std::size_t beams) {
  const auto angles_rad = beam_angles(beams);
  const auto poses = std::span<const Pose2>(setting.poses).first(960'000 / beams);
  std::vector<float> ranges_m(poses.size() * beams);
  for (auto _ : state) built.caster.ranges(ScanRays{poses, angles_rad}, ranges_m);
  count_rays(state, ranges_m.size());
  state_caster(state, built);
}

/// How far a caster's ranges are from the walk's, over the random rays.
void compare_with_walk(benchmark::State& state, const Setting& setting, const Built& walk,
                       const Built& built) {
  std::vector<float> exact_m(setting.rays.size());
  std::vector<float> ranges_m(setting.rays.size());
  walk.caster.ranges(setting.rays, exact_m);
  for (auto _ : state) built.caster.ranges(setting.rays, ranges_m);
  std::vector<double> errors_m;
  double same = 0.0;
  for (std::size_t i = 0; i < ranges_m.size(); ++i) {
    same += exact_m[i] == ranges_m[i] ? 1.0 : 0.0;
    const bool both = std::isfinite(exact_m[i]) && std::isfinite(ranges_m[i]);
    if (both) errors_m.push_back(std::abs(static_cast<double>(exact_m[i] - ranges_m[i])));
  }
  std::sort(errors_m.begin(), errors_m.end());
  const auto quantile = [&](double share) {
    return errors_m[static_cast<std::size_t>(share * static_cast<double>(errors_m.size() - 1))];
  };
  const auto count = static_cast<double>(ranges_m.size());
  state.counters["same_share"] = same / count;
  state.counters["error_p50_m"] = quantile(0.5);
  state.counters["error_p90_m"] = quantile(0.9);
  state.counters["error_p99_m"] = quantile(0.99);
  const auto within = std::upper_bound(errors_m.begin(), errors_m.end(), 0.1) - errors_m.begin();
  state.counters["within_0.1m_share"] =
      static_cast<double>(within) / static_cast<double>(errors_m.size());
}

/// A cloud of particles about one place, weighed by a scan of 60 beams.
void weigh_particles(benchmark::State& state, const Setting& setting, const Built& built,
                     std::size_t particles) {
  const BeamModel model(built.caster);
  const auto angles_rad = beam_angles(60);
  std::vector<float> ranges_m(angles_rad.size());
  const Pose2 truth = setting.poses[3];
  built.caster.ranges(ScanRays{{&truth, 1}, angles_rad}, ranges_m);
  Rng rng(2);
  std::vector<Pose2> poses;
  for (std::size_t i = 0; i < particles; ++i) {
    poses.push_back(truth *
                    Pose2{rng.normal(0.0, 0.3), rng.normal(0.0, 0.3), rng.normal(0.0, 0.1)});
  }
  std::vector<double> out(poses.size());
  for (auto _ : state) model.log_likelihoods(poses, {{}, angles_rad, ranges_m}, out);
  count_rays(state, poses.size() * angles_rad.size());
  state.counters["table_bytes"] = static_cast<double>(model.memory_bytes());
}

void register_all(const Setting& setting, const std::vector<Built>& casters) {
  const auto add = [](const std::string& name, auto run) {
    benchmark::RegisterBenchmark(name.c_str(), run)->Unit(benchmark::kMillisecond);
  };
  for (const Built& built : casters) {
    add("random/" + built.name, [&](benchmark::State& state) { cast_rays(state, setting, built); });
    for (const std::size_t beams : {60, 360}) {
      add("scans" + std::to_string(beams) + "/" + built.name,
          [&, beams](benchmark::State& state) { cast_scans(state, setting, built, beams); });
    }
    add("weigh2000/" + built.name,
        [&](benchmark::State& state) { weigh_particles(state, setting, built, 2000); });
    benchmark::RegisterBenchmark(
        ("accuracy/" + built.name).c_str(),
        [&](benchmark::State& state) { compare_with_walk(state, setting, casters.front(), built); })
        ->Unit(benchmark::kMillisecond)
        ->Iterations(1);
  }
}

}  // namespace
}  // namespace loopstone

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  using namespace loopstone;
  const Setting setting(argc > 1 ? place_of(read_image(argv[1])) : office());
  const std::vector<Built> casters = casters_of(setting.place);
  benchmark::AddCustomContext("map", argc > 1 ? argv[1] : "simulated office");
  benchmark::AddCustomContext("cells", std::to_string(setting.place.occupied.cells().size()));
  benchmark::AddCustomContext("free_cells", std::to_string(setting.place.free_cells.size()));
  benchmark::AddCustomContext("max_range_m", std::to_string(kMaxRangeM));
  register_all(setting, casters);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
