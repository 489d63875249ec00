// How long it takes to track a scan on a submap's grid from a good prediction, printed as JSON:
//   measure_tracking SCANS
// In each of SCANS / 10 random rooms a grid is filled with 20 scans of 1081 beams; ten more are
// aligned to it, their predictions 3 cm and 1 deg off. The surfaces of a scan are timed by
// themselves, since a mapper needs them anyway.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "answers.hpp"
#include "loopstone/registration/grid_matcher.hpp"
#include "loopstone/registration/surface_grid.hpp"
#include "loopstone/sensor/scan_points.hpp"
#include "loopstone/simulation/surface_index.hpp"
#include "registration_pairs.hpp"

namespace loopstone::bench {
namespace {

constexpr int kMapScans = 20;
constexpr int kScansOfRoom = 10;
constexpr double kOffM = 0.03;
constexpr double kOffRad = kPi / 180.0;

struct Figures {
  std::vector<double> surfaces_ms;
  std::vector<double> match_ms;
  std::vector<double> error_mm;
  std::vector<double> error_deg;
};

Pose2 pose_in(const RandomRoom& room, const SurfaceIndex& surfaces, Rng& rng) {
  for (;;) {
    const Pose2 pose{rng.uniform(room.inside.low.x(), room.inside.high.x()),
                     rng.uniform(room.inside.low.y(), room.inside.high.y()),
                     rng.uniform(-kPi, kPi)};
    if (detail::can_stand(room, surfaces, pose.translation())) return pose;
  }
}

void measure_room(std::uint64_t seed, Figures& figures) {
  const RandomRoom room = make_random_room(Rng(seed));
  const SurfaceIndex index(room.world.plan);
  Rng rng = Rng(seed).fork(1);
  BeamTable beams;
  const std::array<double, 2> resolutions_m{0.1, 0.3};  // of a submap
  SurfaceGrid grid(resolutions_m);
  for (int i = 0; i < kMapScans; ++i) {
    const Pose2 pose = pose_in(room, index, rng);
    const LaserScan scan = cast_scan(index, pose, kSensor1081, rng);
    grid.insert(surface_points(scan, Pose2{}, Tangent2::Zero(), {}, beams), pose);
  }
  for (int i = 0; i < kScansOfRoom; ++i) {
    const Pose2 truth = pose_in(room, index, rng);
    const LaserScan scan = cast_scan(index, truth, kSensor1081, rng);
    const double towards = rng.uniform(-kPi, kPi);
    const double turn = rng.uniform() < 0.5 ? -kOffRad : kOffRad;
    const Pose2 prediction{truth.x + kOffM * std::cos(towards), truth.y + kOffM * std::sin(towards),
                           truth.yaw + turn};
    const double start = thread_seconds();
    const auto surfaces = surface_points(scan, Pose2{}, Tangent2::Zero(), {}, beams);
    const double middle = thread_seconds();
    const MatchResult match = match_to_grid(surfaces, grid, prediction, {}, {}, 0);
    const double end = thread_seconds();
    const Pose2& found = match.target_T_source;
    figures.surfaces_ms.push_back(1e3 * (middle - start));
    figures.match_ms.push_back(1e3 * (end - middle));
    figures.error_mm.push_back(1e3 * (found.translation() - truth.translation()).norm());
    figures.error_deg.push_back(std::abs(wrap_angle(found.yaw - truth.yaw)) * 180.0 / kPi);
  }
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values.at(static_cast<std::size_t>(share * static_cast<double>(values.size() - 1)));
}

void print(const char* name, const std::vector<double>& values, const char* end) {
  std::printf("\"%s\": {\"median\": %.6g, \"p95\": %.6g}%s", name, quantile(values, 0.5),
              quantile(values, 0.95), end);
}

}  // namespace
}  // namespace loopstone::bench

int main(int argc, char** argv) {
  const int scans = argc > 1 ? std::max(loopstone::bench::kScansOfRoom, std::atoi(argv[1])) : 1000;
  loopstone::bench::Figures figures;
  for (int room = 0; room < scans / loopstone::bench::kScansOfRoom; ++room) {
    loopstone::bench::measure_room(static_cast<std::uint64_t>(room) + 1, figures);
  }
  std::printf("{\"scans\": %zu, \"beams\": %d, ", figures.match_ms.size(),
              loopstone::bench::kSensor1081.beams);
  loopstone::bench::print("surfaces_ms", figures.surfaces_ms, ", ");
  loopstone::bench::print("match_ms", figures.match_ms, ", ");
  loopstone::bench::print("error_mm", figures.error_mm, ", ");
  loopstone::bench::print("error_deg", figures.error_deg, "}\n");
  return 0;
}
