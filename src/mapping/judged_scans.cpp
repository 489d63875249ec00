#include "mapping/judged_scans.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/mapping/map_quality.hpp"
#include "loopstone/sensor/scan_points.hpp"
#include "mapping/scan_beams.hpp"

namespace loopstone {
namespace {

constexpr auto kMostScans = static_cast<std::size_t>(kJudgedScans.most_scans);

struct Chosen {
  std::size_t scan;
  int stretch;
};

std::vector<Chosen> choose(std::span<const PosedScan> scans) {
  std::vector<Chosen> chosen;
  const Pose2* before = nullptr;
  const Pose2* last_chosen = nullptr;
  double travelled_m = 0.0;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (!usable(scans[i])) continue;
    const Pose2& pose = scans[i].map_T_robot;
    if (before != nullptr) {
      travelled_m +=
          std::min((pose.translation() - before->translation()).norm(), kJudgedScans.jump_m);
    }
    before = &pose;
    if (last_chosen != nullptr) {
      const Pose2 since = last_chosen->inverse() * pose;
      if (hypotenuse(since.x, since.y) < kJudgedScans.spacing_m &&
          std::abs(since.yaw) < kJudgedScans.spacing_rad)
        continue;
    }
    last_chosen = &pose;
    chosen.push_back({i, static_cast<int>(travelled_m / kMapQuality.stretch_m)});
  }
  if (chosen.size() <= kMostScans) return chosen;
  std::vector<Chosen> thinned;
  thinned.reserve(kMostScans);
  for (std::size_t i = 0; i < kMostScans; ++i)
    thinned.push_back(chosen[i * chosen.size() / kMostScans]);
  return thinned;
}

/// Speed of the lidar in its own frame.
Tangent2 lidar_velocity(const PosedScan& posed) {
  const double sweep_s = sweep_seconds(*posed.scan);
  if (sweep_s == 0.0) return Tangent2::Zero();
  return log(posed.map_T_lidar.inverse() * posed.map_T_lidar_end) / sweep_s;
}

/// How far a return lies off the chord of its two neighbours, as the noise of one return: the
/// variance of p - (1 - a) before - a after is sigma^2 (1 + (1 - a)^2 + a^2).
void add_noise(const Eigen::Vector2d& before, const Eigen::Vector2d& at,
               const Eigen::Vector2d& after, const Eigen::Vector2d& normal,
               std::vector<float>& noise_m) {
  const Eigen::Vector2d tangent(-normal.y(), normal.x());
  const double back = tangent.dot(before - at);
  const double ahead = tangent.dot(after - at);
  if (!(back * ahead < 0.0) || std::abs(back) > kJudgedScans.neighbour_m ||
      std::abs(ahead) > kJudgedScans.neighbour_m)
    return;
  const double a = back / (back - ahead);
  const double off = normal.dot(at - (1.0 - a) * before - a * after);
  noise_m.push_back(
      static_cast<float>(std::abs(off) / std::sqrt(1.0 + (1.0 - a) * (1.0 - a) + a * a)));
}

JudgedScan read(const PosedScan& posed, int stretch, BeamTable& table) {
  const LaserScan& scan = *posed.scan;
  JudgedScan judged{.stretch = stretch, .stamp = scan.stamp};
  const Tangent2 velocity = lidar_velocity(posed);
  const SurfaceOptions surface_options{.range_max_m = kJudgedScans.most_range_m,
                                       .points_max = kJudgedScans.most_points};
  const auto surfaces = surface_points(scan, Pose2{}, velocity, surface_options, table);
  const auto points = scan_points(scan, Pose2{}, velocity);
  const Eigen::Matrix2d rotation = posed.map_T_lidar.rotation();
  const Eigen::Vector2d origin = posed.map_T_lidar.translation();
  std::size_t next = 0;
  judged.returns.reserve(surfaces.size());
  for (const SurfacePoint& surface : surfaces) {
    if (surface.weight < 1.0F) continue;
    const Eigen::Vector2d on_line = surface.position.cast<double>();
    const Eigen::Vector2d normal = surface.normal.cast<double>();
    const Eigen::Vector2d tangent(-normal.y(), normal.x());
    // Both lists are in the order of the beams: the return is the next one that differs across the
    // wall only.
    std::size_t own = next;
    while (own < points.size() &&
           !(std::abs(tangent.dot(points[own] - on_line)) < kJudgedScans.same_beam_m &&
             std::abs(normal.dot(points[own] - on_line)) < kMapQuality.most_offset_m)) {
      ++own;
    }
    if (own == points.size()) continue;
    next = own + 1;
    if (own > 0 && own + 1 < points.size()) {
      add_noise(points[own - 1], points[own], points[own + 1], normal, judged.noise_m);
    }
    judged.returns.push_back({(origin + rotation * on_line).cast<float>(),
                              (origin + rotation * points[own]).cast<float>(),
                              (rotation * normal).cast<float>()});
  }
  constexpr auto kMostBeams = static_cast<std::size_t>(kJudgedScans.most_beams);
  const std::size_t stride =
      std::max<std::size_t>(1, (scan.ranges_m.size() + kMostBeams - 1) / kMostBeams);
  std::size_t beam = 0;
  for_each_beam(
      posed, {.max_range_m = scan.range_max_m > 0.0 ? scan.range_max_m : kJudgedScans.most_range_m},
      table, [&](const Beam& seen) {
        if (beam++ % stride != 0 || !seen.hit) return;
        judged.beams.push_back({seen.start.cast<float>(), seen.end.cast<float>()});
      });
  return judged;
}

}  // namespace

std::vector<JudgedScan> judged_scans(std::span<const PosedScan> scans, Threads threads) {
  constexpr std::size_t kPerTask = 64;
  const auto chosen = choose(scans);
  std::vector<JudgedScan> judged(chosen.size());
  parallel_for((chosen.size() + kPerTask - 1) / kPerTask, threads, [&](std::size_t task) {
    BeamTable table;
    const std::size_t end = std::min((task + 1) * kPerTask, chosen.size());
    for (std::size_t i = task * kPerTask; i < end; ++i)
      judged[i] = read(scans[chosen[i].scan], chosen[i].stretch, table);
  });
  return judged;
}

}  // namespace loopstone
