// How far the returns of a log lie from the surfaces of its map, for comparing simulated noise with
// recorded noise.
//
//   measure_residuals LOG [THREADS]
//
// The log is mapped; then every return is held against the line through all returns around it.
// Writes one JSON object:
//   spread_m         of returns about flat surfaces: 1.4826 times the median distance; by range
//   outlier_share    of returns at flat surfaces: farther from them than 5 cm
//   lone_share       of returns: where hardly any other scan saw anything (people, mixed pixels)
//   bad_share, no_return_share       of beams
//   repeat_m         of the same beam in two scans while the robot stands: standard deviation
//   repeat_lost_share                beams that only one of both has

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "loopstone/formats/log_reader.hpp"
#include "loopstone/sensor/scan_points.hpp"
#include "loopstone/slam/mapper.hpp"

using namespace loopstone;

namespace {

constexpr double kCellM = 0.15;
constexpr int kFewScans = 4;     ///< a place that fewer saw tells nothing of a surface
constexpr double kFlatM = 0.04;  ///< thickness of what is a flat surface, standard deviation
constexpr double kLongM = 0.08;  ///< and its length
constexpr double kOutlierM = 0.05;
constexpr double kMovedM = 0.1;  ///< between scans that are looked at
constexpr double kMovedRad = 0.1;
constexpr double kStillM = 0.002;  ///< between scans of a robot that stands
constexpr double kStillRad = 0.0005;
constexpr double kNearM = 5.0;
constexpr double kFarM = 10.0;

/// The returns in one square of the map.
struct Patch {
  double count = 0.0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  int scans = 0;
  std::size_t last_scan = ~std::size_t{0};

  void add(const Eigen::Vector2d& point, std::size_t scan) {
    count += 1.0;
    sum += point;
    squares += point * point.transpose();
    if (scan != last_scan) ++scans;
    last_scan = scan;
  }
};

class Patches {
 public:
  void add(const Eigen::Vector2d& point, std::size_t scan) {
    patches_[key(column(point.x()), column(point.y()))].add(point, scan);
  }

  struct Surroundings {
    Patch all;
    int most_scans = 0;
  };
  /// Of the square of a point and those around it.
  [[nodiscard]] Surroundings around(const Eigen::Vector2d& point) const {
    Surroundings found;
    for (std::int64_t y = column(point.y()) - 1; y <= column(point.y()) + 1; ++y) {
      for (std::int64_t x = column(point.x()) - 1; x <= column(point.x()) + 1; ++x) {
        const auto patch = patches_.find(key(x, y));
        if (patch == patches_.end()) continue;
        found.all.count += patch->second.count;
        found.all.sum += patch->second.sum;
        found.all.squares += patch->second.squares;
        found.most_scans = std::max(found.most_scans, patch->second.scans);
      }
    }
    return found;
  }

 private:
  static std::int64_t column(double at) {
    return static_cast<std::int64_t>(std::floor(at / kCellM));
  }
  static std::int64_t key(std::int64_t x, std::int64_t y) { return x * 10'000'019 + y; }
  std::unordered_map<std::int64_t, Patch> patches_{};
};

/// Distance to the line through what is around, if that is a flat surface.
std::optional<double> distance_to_surface(const Patch& all, const Eigen::Vector2d& point) {
  const Eigen::Vector2d mean = all.sum / all.count;
  const Eigen::Matrix2d covariance = all.squares / all.count - mean * mean.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(covariance);
  const double thickness = std::sqrt(std::max(0.0, solver.eigenvalues()[0]));
  const double length = std::sqrt(std::max(0.0, solver.eigenvalues()[1]));
  if (thickness > kFlatM || length < kLongM) return std::nullopt;
  return std::abs(solver.eigenvectors().col(0).dot(point - mean));
}

double spread_of(std::vector<double> distances) {
  if (distances.empty()) return 0.0;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return 1.4826 * *middle;  // of a normal distribution, Rousseeuw and Croux 1993
}

/// What the log says while the robot stands.
struct Repeats {
  double squares = 0.0;
  double count = 0.0;
  double lost = 0.0;

  void add(const LaserScan& a, const LaserScan& b) {
    if (a.ranges_m.size() != b.ranges_m.size()) return;
    for (std::size_t beam = 0; beam < a.ranges_m.size(); ++beam) {
      const bool in_a = std::isfinite(a.ranges_m[beam]);
      if (in_a != std::isfinite(b.ranges_m[beam])) lost += 1.0;
      if (!in_a || !std::isfinite(b.ranges_m[beam])) continue;
      const auto off = static_cast<double>(a.ranges_m[beam] - b.ranges_m[beam]);
      if (std::abs(off) > 0.1) continue;  // an edge, or somebody
      squares += off * off;
      count += 1.0;
    }
  }
};

struct Beams {
  double all = 0.0;
  double bad = 0.0;
  double no_return = 0.0;

  void add(const LaserScan& scan) {
    for (const float range : scan.ranges_m) {
      all += 1.0;
      bad += std::isnan(range) ? 1.0 : 0.0;
      no_return += std::isinf(range) ? 1.0 : 0.0;
    }
  }
};

/// A scan as points of the map.
struct Placed {
  std::vector<Eigen::Vector2d> points{};
  std::vector<double> ranges_m{};
};

Placed placed(const LaserScan& scan, const Pose2& map_T_robot, const RobotModel& robot) {
  Placed result;
  const Pose2 map_T_lidar = map_T_robot * mount_of(scan, robot);
  for (std::size_t beam = 0; beam < scan.ranges_m.size(); ++beam) {
    const auto range = static_cast<double>(scan.ranges_m[beam]);
    if (!std::isfinite(range)) continue;
    const double angle = scan.angle_rad(beam);
    result.points.push_back(map_T_lidar *
                            Eigen::Vector2d(range * std::cos(angle), range * std::sin(angle)));
    result.ranges_m.push_back(range);
  }
  return result;
}

double share(double part, double whole) { return whole > 0.0 ? part / whole : 0.0; }

nlohmann::json residuals_of(const std::vector<Placed>& scans) {
  Patches patches;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    for (const Eigen::Vector2d& point : scans[i].points) patches.add(point, i);
  }
  std::vector<double> all;
  std::vector<double> near;
  std::vector<double> far;
  double returns = 0.0;
  double lone = 0.0;
  double outliers = 0.0;
  for (const Placed& scan : scans) {
    for (std::size_t i = 0; i < scan.points.size(); ++i) {
      returns += 1.0;
      const Patches::Surroundings around = patches.around(scan.points[i]);
      if (around.most_scans < kFewScans) {
        lone += 1.0;
        continue;
      }
      const auto distance = distance_to_surface(around.all, scan.points[i]);
      if (!distance) continue;
      all.push_back(*distance);
      outliers += *distance > kOutlierM ? 1.0 : 0.0;
      if (scan.ranges_m[i] < kNearM) near.push_back(*distance);
      if (scan.ranges_m[i] > kFarM) far.push_back(*distance);
    }
  }
  return {{"returns", returns},
          {"flat_share", share(static_cast<double>(all.size()), returns)},
          {"spread_m", spread_of(all)},
          {"spread_near_m", spread_of(near)},
          {"spread_far_m", spread_of(far)},
          {"outlier_share", share(outliers, static_cast<double>(all.size()))},
          {"lone_share", share(lone, returns)}};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "measure_residuals LOG [THREADS]\n");
    return 2;
  }
  const auto log = open_log(argv[1]);
  const RobotModel robot = log->robot(RobotModel{});
  Mapper mapper(robot, MapOptions{}, Threads{argc > 2 ? std::atoi(argv[2]) : 0});
  std::vector<LaserScan> scans;
  while (const auto message = log->next()) {
    if (const auto* scan = std::get_if<LaserScan>(&*message)) scans.push_back(*scan);
    mapper.add(*message);
  }
  const MapResult result = mapper.finish();

  Beams beams;
  Repeats repeats;
  std::vector<Placed> kept;
  std::optional<Pose2> map_T_kept;
  std::optional<Pose2> map_T_last;
  const LaserScan* last = nullptr;
  for (const LaserScan& scan : scans) {
    beams.add(scan);
    const auto map_T_robot = result.trajectory.nearest(scan.stamp, Duration{0});
    if (!map_T_robot) continue;
    if (map_T_last && last != nullptr) {
      const Pose2 moved = map_T_last->inverse() * *map_T_robot;
      if (moved.translation().norm() < kStillM && std::abs(moved.yaw) < kStillRad)
        repeats.add(*last, scan);
    }
    map_T_last = map_T_robot;
    last = &scan;
    if (map_T_kept) {
      const Pose2 moved = map_T_kept->inverse() * *map_T_robot;
      if (moved.translation().norm() < kMovedM && std::abs(moved.yaw) < kMovedRad) continue;
    }
    map_T_kept = map_T_robot;
    kept.push_back(placed(scan, *map_T_robot, robot));
  }
  nlohmann::json json = residuals_of(kept);
  json["scans"] = scans.size();
  json["scans_compared"] = kept.size();
  json["bad_share"] = share(beams.bad, beams.all);
  json["no_return_share"] = share(beams.no_return, beams.all);
  json["repeat_m"] = std::sqrt(share(repeats.squares, 2.0 * repeats.count));
  json["repeats"] = repeats.count;
  json["repeat_lost_share"] = share(repeats.lost, repeats.count + repeats.lost);
  std::printf("%s\n", json.dump().c_str());
  return 0;
}
