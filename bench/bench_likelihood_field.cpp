// How long the likelihood field takes to weigh particles, beside a form of beluga's update
// (beluga_form.hpp): one core, particles within a cloud of 2 m, as when tracking, and all over the
// map, as when lost. Run by bench/localization_speed.py.

#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "beluga_form.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/grid/distance_transform.hpp"
#include "loopstone/localization/likelihood_field_model.hpp"
#include "loopstone/registration/likelihood_field.hpp"
#include "loopstone/sensor/scan_points.hpp"
#include "loopstone/simulation/surface_index.hpp"
#include "loopstone/simulation/world.hpp"
#include "registration_pairs.hpp"

namespace loopstone {
namespace {

constexpr double kCloudSide_m = 2.0;

struct Scene {
  Grid<std::int8_t> map;
  Grid<float> distances_m;
  LikelihoodFieldModel ours;
  bench::BelugaForm theirs;
  Pose2 map_T_robot;
  std::vector<Eigen::Vector2d> scan;

  explicit Scene(const std::string& name) : Scene(make_world(name, 1)) {}

 private:
  explicit Scene(const World& world)
      : map(true_map(world, 0.05)),
        distances_m(distance_transform(visible_walls(map, 65))),
        ours(map),
        theirs(distances_m) {
    const SurfaceIndex surfaces(world.plan);
    Rng rng(5);
    do {
      map_T_robot = anywhere(rng);
    } while (map[map.frame().cell_of(map_T_robot.translation())] != 0 ||
             surfaces.distance(map_T_robot.translation(), 1.0) < 0.8);
    scan = scan_points(bench::cast_scan(surfaces, map_T_robot, bench::kSensor1081, rng), Pose2{});
  }

 public:
  [[nodiscard]] Pose2 anywhere(Rng& rng) const {
    const GridFrame& frame = map.frame();
    return {frame.origin.x() + rng.uniform(0.0, frame.columns * frame.resolution),
            frame.origin.y() + rng.uniform(0.0, frame.rows * frame.resolution),
            rng.uniform(-kPi, kPi)};
  }
  [[nodiscard]] Pose2 in_cloud(Rng& rng) const {
    const double half = 0.5 * kCloudSide_m;
    return {map_T_robot.x + rng.uniform(-half, half), map_T_robot.y + rng.uniform(-half, half),
            wrap_angle(map_T_robot.yaw + rng.uniform(-0.3, 0.3))};
  }
};

const Scene& scene(bool campus) {
  static const Scene office("office");
  static const Scene wide("campus");
  return campus ? wide : office;
}

/// Arguments: particles, beams, all over the map (else in a cloud), the large map (else the small
/// one).
struct Case {
  const Scene& on;
  std::vector<Pose2> poses{};
  std::vector<Eigen::Vector2d> points{};

  explicit Case(benchmark::State& state) : on(scene(state.range(3) != 0)) {
    Rng rng(11);
    const bool everywhere = state.range(2) != 0;
    while (poses.size() < static_cast<std::size_t>(state.range(0))) {
      poses.push_back(everywhere ? on.anywhere(rng) : on.in_cloud(rng));
    }
    const auto beams = static_cast<std::size_t>(state.range(1));
    for (std::size_t i = 0; i < beams; ++i) points.push_back(on.scan[i * on.scan.size() / beams]);
    state.counters["columns"] = on.map.frame().columns;
    state.counters["rows"] = on.map.frame().rows;
  }
  [[nodiscard]] std::vector<Eigen::Vector2f> float_points() const {
    std::vector<Eigen::Vector2f> result;
    for (const auto& point : points) result.push_back(point.cast<float>());
    return result;
  }
  void count(benchmark::State& state) const {
    state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) *
                            static_cast<std::int64_t>(poses.size() * points.size()));
  }
};

void loopstone_field(benchmark::State& state) {
  const Case with(state);
  const auto points = with.float_points();
  std::vector<double> out(with.poses.size());
  for (auto _ : state) {
    with.on.ours.log_likelihoods(with.poses, points, out);
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
  }
  with.count(state);
}

void loopstone_field_skipping(benchmark::State& state) {
  const Case with(state);
  const auto points = with.float_points();
  std::vector<double> out(with.poses.size());
  for (auto _ : state) {
    benchmark::DoNotOptimize(with.on.ours.log_likelihoods_skipping(with.poses, points, out));
    benchmark::ClobberMemory();
  }
  with.count(state);
}

void form_of_beluga(benchmark::State& state) {
  const Case with(state);
  std::vector<bench::BelugaForm::State> states;
  for (const Pose2& pose : with.poses) states.push_back(bench::BelugaForm::state_of(pose));
  bench::BelugaForm::Points points;
  for (const auto& point : with.points) points.emplace_back(point.x(), point.y());
  std::vector<double> weights(states.size());
  for (auto _ : state) {
    std::fill(weights.begin(), weights.end(), 1.0);
    with.on.theirs.reweight(states, points, weights);
    benchmark::DoNotOptimize(weights.data());
    benchmark::ClobberMemory();
  }
  with.count(state);
}

void build_field(benchmark::State& state) {
  const Scene& on = scene(state.range(0) != 0);
  for (auto _ : state) benchmark::DoNotOptimize(LikelihoodFieldModel(on.map, {}, {1}));
  state.counters["columns"] = on.map.frame().columns;
  state.counters["rows"] = on.map.frame().rows;
}

void cases(benchmark::internal::Benchmark* bench) {
  for (const int campus : {0, 1}) {
    for (const int everywhere : {0, 1}) {
      bench->Args({2000, 60, everywhere, campus});
      bench->Args({10000, 60, everywhere, campus});
      bench->Args({10000, 1081, everywhere, campus});
    }
  }
  bench->Unit(benchmark::kMillisecond);
}
BENCHMARK(loopstone_field)->Apply(cases);
BENCHMARK(loopstone_field_skipping)->Apply(cases);
BENCHMARK(form_of_beluga)->Apply(cases);
BENCHMARK(build_field)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace loopstone
