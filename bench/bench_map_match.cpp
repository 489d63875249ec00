// Finds scans on maps, from no guess and from bad ones: how often the answer is right, how often a
// wrong one is called sure, and how long a scan takes on one core.
//   bench_map_match [--json OUT] [--trials N] [--only NAME] [--verbose 1]

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/registration/map_match.hpp"
#include "loopstone/sensor/scan_points.hpp"
#include "loopstone/simulation/surface_index.hpp"
#include "loopstone/simulation/world.hpp"
#include "registration_pairs.hpp"

namespace loopstone {
namespace {

using Points = std::vector<Eigen::Vector2d>;

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

Points simulated_scan(const SurfaceIndex& surfaces, const Pose2& map_T_laser, Rng& rng) {
  return scan_points(bench::cast_scan(surfaces, map_T_laser, bench::kSensor1081, rng), Pose2{});
}

/// Somewhere in the reachable space, 0.3 m from everything.
Pose2 random_place(const Grid<std::int8_t>& map, const SurfaceIndex& surfaces, Rng& rng) {
  while (true) {
    const Cell cell{static_cast<int>(rng.below(static_cast<std::uint64_t>(map.frame().columns))),
                    static_cast<int>(rng.below(static_cast<std::uint64_t>(map.frame().rows)))};
    if (map[cell] != 0) continue;
    const Eigen::Vector2d at = map.frame().centre_of(cell) +
                               Eigen::Vector2d(rng.uniform(-0.02, 0.02), rng.uniform(-0.02, 0.02));
    if (surfaces.distance(at, 1.0) < 0.3) continue;
    return {at.x(), at.y(), rng.uniform(-kPi, kPi)};
  }
}

bool is_right(const Pose2& pose, const Pose2& truth) {
  return std::hypot(pose.x - truth.x, pose.y - truth.y) <= 0.05 &&
         std::abs(wrap_angle(pose.yaw - truth.yaw)) <= radians(0.5);
}

struct Task {
  std::string name;
  std::string world;
  bool guess = false;
  int seeds = 1;
  int trials = 1;
};

nlohmann::json measure(const Task& task, bool verbose) {
  int right = 0;
  int sure = 0;
  int sure_right = 0;
  int listed = 0;
  double build_s = 0.0;
  std::size_t bytes = 0;
  double area_m2 = 0.0;
  std::vector<double> times_ms;
  std::vector<double> errors_m;
  std::vector<double> errors_deg;
  for (int seed = 1; seed <= task.seeds; ++seed) {
    const World world = make_world(task.world, static_cast<std::uint64_t>(seed));
    const Grid<std::int8_t> map = true_map(world, 0.05);
    const SurfaceIndex surfaces(world.plan);
    const double before = cpu_seconds();
    const MapSearch search(map);
    build_s = cpu_seconds() - before;
    bytes = search.memory_bytes();
    area_m2 = world.floor_area_m2;
    Rng rng(static_cast<std::uint64_t>(seed));
    const int trials = task.trials / task.seeds + (seed <= task.trials % task.seeds ? 1 : 0);
    for (int trial = 0; trial < trials; ++trial) {
      const Pose2 truth = random_place(map, surfaces, rng);
      const Points scan = simulated_scan(surfaces, truth, rng);
      std::optional<SearchWindow> window;
      if (task.guess) {
        const double way = rng.uniform(-kPi, kPi);
        const double off = rng.uniform(0.0, 1.0);
        window = SearchWindow{{truth.x + off * std::cos(way), truth.y + off * std::sin(way),
                               wrap_angle(truth.yaw + radians(rng.uniform(-45.0, 45.0)))},
                              1.1,
                              radians(50.0)};
      }
      const double start = cpu_seconds();
      const MapMatch match = match_on_map(scan, search, window);
      times_ms.push_back(1e3 * (cpu_seconds() - start));
      const bool correct = match.found() && is_right(match.poses[0].target_T_source, truth);
      right += correct;
      sure += match.sure;
      sure_right += match.sure && correct;
      listed += std::any_of(match.poses.begin(), match.poses.end(), [&](const MatchResult& pose) {
        return is_right(pose.target_T_source, truth);
      });
      if (correct) {
        const Pose2& pose = match.poses[0].target_T_source;
        errors_m.push_back(std::hypot(pose.x - truth.x, pose.y - truth.y));
        errors_deg.push_back(degrees(std::abs(wrap_angle(pose.yaw - truth.yaw))));
      }
      if (verbose && (!correct || !match.sure)) {
        std::printf("%s seed %d trial %d truth %.2f %.2f %.2f points %zu %s %s:", task.name.c_str(),
                    seed, trial, truth.x, truth.y, truth.yaw, scan.size(),
                    correct ? "right" : "WRONG", match.sure ? "SURE" : "unsure");
        for (const auto& pose : match.poses)
          std::printf("  %.3f (%.2f %.2f %.2f)", pose.score, pose.target_T_source.x,
                      pose.target_T_source.y, pose.target_T_source.yaw);
        std::printf("\n");
      }
    }
  }
  const auto median = [](std::vector<double> values) {
    if (values.empty()) return 0.0;
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
  };
  const auto trials = static_cast<double>(task.trials);
  return {{"name", task.name},
          {"trials", task.trials},
          {"correct_share", sure > 0 ? static_cast<double>(sure_right) / sure : 1.0},
          {"wrong_called_sure", (sure - sure_right) / trials},
          {"sure_share", sure / trials},
          {"best_correct_share", right / trials},
          {"listed_share", listed / trials},
          {"median_ms", median(times_ms)},
          {"max_ms", *std::max_element(times_ms.begin(), times_ms.end())},
          {"median_error_m", median(errors_m)},
          {"median_error_deg", median(errors_deg)},
          {"area_m2", area_m2},
          {"build_ms", 1e3 * build_s},
          {"memory_mb", static_cast<double>(bytes) / 1e6}};
}

}  // namespace
}  // namespace loopstone

int main(int argc, char** argv) {
  std::string json_path;
  std::string only;
  int trials = 500;
  bool verbose = false;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string flag = argv[i];
    if (flag == "--json") json_path = argv[i + 1];
    if (flag == "--trials") trials = std::max(1, std::atoi(argv[i + 1]));
    if (flag == "--only") only = argv[i + 1];
    if (flag == "--verbose") verbose = std::string(argv[i + 1]) == "1";
  }
  const int fewer = std::max(1, trials / 5);
  const std::vector<loopstone::Task> tasks{
      {"campus, no guess", "campus", false, 4, trials},
      {"campus, within 1 m and 45 deg", "campus", true, 4, trials},
      {"office, no guess", "office", false, 4, fewer},
      {"warehouse, no guess", "warehouse", false, 2, fewer},
      {"equal rooms, no guess", "rooms", false, 2, fewer},
      {"corridor, no guess", "corridor", false, 2, fewer},
      {"corridor, within 1 m and 45 deg", "corridor", true, 2, fewer},
  };
  nlohmann::json rows = nlohmann::json::array();
  for (const auto& task : tasks) {
    if (!only.empty() && task.name.find(only) == std::string::npos) continue;
    rows.push_back(loopstone::measure(task, verbose));
    std::printf("%s\n", rows.back().dump().c_str());
    std::fflush(stdout);
  }
  if (!json_path.empty()) {
    std::ofstream(json_path) << nlohmann::json{{"section", "map_match"}, {"rows", rows}}.dump(2)
                             << "\n";
  }
}
