#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/sensor/laser_scan.hpp"
#include "loopstone/simulation/surface_index.hpp"
#include "random_room.hpp"

namespace loopstone::bench {

/// Two scans of one room and the truth between them. The lidar is the robot: robot_T_lidar is the
/// identity.
struct ScanPair {
  LaserScan target;
  LaserScan source;
  Pose2 target_T_source;
};

struct PairSensor {
  int beams = 1081;
  double field_deg = 270.0;
  double noise_m = 0.01;
  double range_max_m = 30.0;
};
inline constexpr PairSensor kSensor1081{};
inline constexpr PairSensor kSensor180{.beams = 180, .field_deg = 179.0};

/// How far apart the two poses may be.
struct PairBin {
  double radius_m = 0.0;
  double yaw_deg = 0.0;
};
inline constexpr std::array<PairBin, 5> kPairBins{PairBin{0.1, 5.0}, PairBin{0.2, 10.0},
                                                  PairBin{0.3, 20.0}, PairBin{0.5, 30.0},
                                                  PairBin{0.8, 45.0}};

/// What the sensor sees from a pose; noise along the beam.
[[nodiscard]] inline LaserScan cast_scan(const SurfaceIndex& surfaces, const Pose2& map_T_lidar,
                                         const PairSensor& sensor, Rng& rng) {
  const double degree = kPi / 180.0;
  LaserScan scan{.angle_min_rad = -0.5 * sensor.field_deg * degree,
                 .angle_increment_rad = sensor.field_deg * degree / (sensor.beams - 1),
                 .range_min_m = 0.05,
                 .range_max_m = sensor.range_max_m};
  scan.ranges_m.reserve(static_cast<std::size_t>(sensor.beams));
  for (int beam = 0; beam < sensor.beams; ++beam) {
    const double angle = map_T_lidar.yaw + scan.angle_rad(static_cast<std::size_t>(beam));
    const double range = surfaces.cast(map_T_lidar.translation(),
                                       {std::cos(angle), std::sin(angle)}, sensor.range_max_m) +
                         rng.normal(0.0, sensor.noise_m);
    scan.ranges_m.push_back(static_cast<float>(
        range > sensor.range_max_m ? std::numeric_limits<double>::infinity() : range));
  }
  return scan;
}

namespace detail {

/// Free and with room to stand.
inline bool can_stand(const RandomRoom& room, const SurfaceIndex& surfaces,
                      const Eigen::Vector2d& point) {
  constexpr double kClearance = 0.35;
  const auto& [low, high] = room.inside;
  if ((point - low).minCoeff() < kClearance || (high - point).minCoeff() < kClearance) return false;
  for (const Box& box : room.world.plan.boxes) {
    if (is_inside(box, point)) return false;
  }
  return surfaces.distance(point, kClearance) >= kClearance;
}

/// Nothing stands between the two poses: the robot came straight from one to the other.
inline bool see_each_other(const SurfaceIndex& surfaces, const Eigen::Vector2d& a,
                           const Eigen::Vector2d& b) {
  const double apart = (b - a).norm();
  return apart < 1e-9 || !(surfaces.cast(a, (b - a) / apart, apart) < apart);
}

}  // namespace detail

/// Pairs from `count` / 4 random rooms. The difference of the poses is uniform in the bin's disc
/// and interval of angles; the pose in the room and its heading are uniform where there are 0.35 m
/// around it. Pair i does not depend on `count`.
[[nodiscard]] inline std::vector<ScanPair> make_scan_pairs(const PairSensor& sensor,
                                                           const PairBin& bin, int count,
                                                           std::uint64_t seed) {
  constexpr int kPairsOfRoom = 4;
  std::vector<ScanPair> pairs;
  pairs.reserve(static_cast<std::size_t>(count));
  for (std::uint64_t number = 0; static_cast<int>(pairs.size()) < count; ++number) {
    const RandomRoom room = make_random_room(Rng(seed).fork(2 * number));
    const SurfaceIndex surfaces(room.world.plan);
    Rng rng = Rng(seed).fork(2 * number + 1);
    for (int made = 0; made < kPairsOfRoom && static_cast<int>(pairs.size()) < count;) {
      const Pose2 map_T_target{rng.uniform(room.inside.low.x(), room.inside.high.x()),
                               rng.uniform(room.inside.low.y(), room.inside.high.y()),
                               rng.uniform(-kPi, kPi)};
      const double away = bin.radius_m * std::sqrt(rng.uniform());
      const double towards = rng.uniform(-kPi, kPi);
      const double turn = rng.uniform(-bin.yaw_deg, bin.yaw_deg) * kPi / 180.0;
      const Pose2 target_T_source{away * std::cos(towards), away * std::sin(towards), turn};
      const Pose2 map_T_source = map_T_target * target_T_source;
      if (!detail::can_stand(room, surfaces, map_T_target.translation()) ||
          !detail::can_stand(room, surfaces, map_T_source.translation()) ||
          !detail::see_each_other(surfaces, map_T_target.translation(),
                                  map_T_source.translation())) {
        continue;
      }
      pairs.push_back({.target = cast_scan(surfaces, map_T_target, sensor, rng),
                       .source = cast_scan(surfaces, map_T_source, sensor, rng),
                       .target_T_source = target_T_source});
      ++made;
    }
  }
  return pairs;
}

}  // namespace loopstone::bench
