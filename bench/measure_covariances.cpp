// Whether what a map says of its own accuracy is true: errors of poses to one another against the
// covariances that the pose graph gives them.
//
//   measure_covariances LOG TRUTH.tum [THREADS]
//
// The log is mapped. Pairs of key scans are drawn by the way between them, and pairs that are near
// in space though far apart on the way (revisits). Writes one JSON array, an object a kind of pair:
//   kind, pairs
//   nees             mean of e^T C^-1 e / 3; 1 is ideal, more is overconfident
//   nees_position, nees_heading       of these alone, by their number of dimensions
//   nees_median      median of e^T C^-1 e over that of chi squared
//   inside_share     in the 95 % ellipsoid
//   error_m, error_rad, sigma_m, sigma_rad          root mean squares; sigma_m of both directions
// Kinds that begin with "drift" are of the path alone, mapped without loop closing and adjustment,
// against what adds up along it.

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/covariance.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/slam/robot_correction.hpp"

using namespace loopstone;

namespace {

constexpr int kPairs = 400;            ///< of a kind
constexpr double kMedianChi2 = 2.366;  ///< of three degrees of freedom
constexpr double kInsideChi2 = 7.815;
constexpr double kRevisitM = 1.0;
constexpr double kAwayM = 20.0;
constexpr double kNoiseM = 0.003;  ///< of a match by itself
constexpr double kNoiseRad = 0.001;

/// A key scan where map and truth know it.
struct Key {
  NodeId node;
  Pose2 map_T_robot;
  Pose2 world_T_robot;
  double travelled_m = 0.0;
};

std::vector<Key> keys_of(const MapResult& result, const Trajectory& truth) {
  std::vector<Key> keys;
  double travelled_m = 0.0;
  for (std::size_t i = 0; i < result.graph.poses.size(); ++i) {
    const Pose2& pose = result.graph.poses[i];
    if (i > 0) travelled_m += (pose.translation() - result.graph.poses[i - 1].translation()).norm();
    const auto world_T_robot = truth.at(result.node_stamps[i]);
    if (world_T_robot)
      keys.push_back({NodeId{static_cast<int>(i)}, pose, *world_T_robot, travelled_m});
  }
  return keys;
}

/// Pairs of key scans that are `way_m` apart on the path.
std::vector<std::pair<std::size_t, std::size_t>> apart(const std::vector<Key>& keys, double way_m) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  std::size_t j = 0;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    j = std::max(j, i + 1);
    while (j < keys.size() && keys[j].travelled_m - keys[i].travelled_m < way_m) ++j;
    if (j < keys.size()) pairs.emplace_back(i, j);
  }
  return pairs;
}

std::vector<std::pair<std::size_t, std::size_t>> revisits(const std::vector<Key>& keys) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t j = 0; j < keys.size(); ++j) {
    for (std::size_t i = 0; i < j && keys[j].travelled_m - keys[i].travelled_m > kAwayM; ++i) {
      const Pose2 between = keys[i].world_T_robot.inverse() * keys[j].world_T_robot;
      if (between.translation().norm() < kRevisitM) pairs.emplace_back(i, j);
    }
  }
  return pairs;
}

double ratio(double part, double whole) { return whole > 0.0 ? part / whole : 0.0; }

nlohmann::json judged(const std::string& kind, const std::vector<Key>& keys,
                      std::vector<std::pair<std::size_t, std::size_t>> pairs,
                      const std::function<Eigen::Matrix3d(const Key&, const Key&)>& between) {
  Rng rng(1);
  while (pairs.size() > kPairs) {
    std::swap(pairs[rng.below(pairs.size())], pairs.back());
    pairs.pop_back();
  }
  if (pairs.empty()) return {};
  std::vector<double> chi2;
  double position = 0.0;
  double heading = 0.0;
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  Eigen::Vector3d variances = Eigen::Vector3d::Zero();
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const Key& from = keys[pairs[p].first];
    const Key& to = keys[pairs[p].second];
    const Eigen::Matrix3d covariance = between(from, to);
    const Pose2 told = from.map_T_robot.inverse() * to.map_T_robot;
    const Pose2 real = from.world_T_robot.inverse() * to.world_T_robot;
    const Eigen::Vector3d error(told.x - real.x, told.y - real.y, wrap_angle(told.yaw - real.yaw));
    chi2.push_back(error.dot(covariance.ldlt().solve(error)));
    const Eigen::Matrix2d of_position = covariance.topLeftCorner<2, 2>();
    position += error.head<2>().dot(of_position.ldlt().solve(error.head<2>())) / 2.0;
    heading += error.z() * error.z() / covariance(2, 2);
    squares += error.cwiseAbs2();
    variances += covariance.diagonal();
  }
  const double count = static_cast<double>(chi2.size());
  double sum = 0.0;
  for (const double value : chi2) sum += value;
  std::ranges::sort(chi2);
  const auto inside = std::ranges::upper_bound(chi2, kInsideChi2) - chi2.begin();
  return {{"kind", kind},
          {"pairs", chi2.size()},
          {"nees", ratio(sum, 3.0 * count)},
          {"nees_position", ratio(position, count)},
          {"nees_heading", ratio(heading, count)},
          {"nees_median", chi2[chi2.size() / 2] / kMedianChi2},
          {"inside_share", ratio(static_cast<double>(inside), count)},
          {"error_m", std::sqrt(ratio(squares.head<2>().sum(), count))},
          {"error_rad", std::sqrt(ratio(squares.z(), count))},
          {"sigma_m", std::sqrt(ratio(variances.head<2>().sum(), count))},
          {"sigma_rad", std::sqrt(ratio(variances.z(), count))}};
}

/// As `loopstone map` does it: once more where beams are off.
MapResult map_of(const char* path, const MapOptions& options, Threads threads) {
  const RobotModel robot = open_log(path)->robot(RobotModel{});
  const auto feed = [&](Mapper& mapper) {
    const auto log = open_log(path);
    while (const auto message = log->next()) mapper.add(*message);
  };
  Mapper mapper(robot, options, threads);
  feed(mapper);
  const Calibration found = mapper.judge_robot();
  if (!found.map_is_bent()) return mapper.finish();
  Mapper again(corrected_robot(robot, found), options, threads);
  feed(again);
  return again.finish();
}

std::string on_the_way(double way_m) {
  return way_m == 0.0 ? "consecutive" : std::to_string(std::lround(way_m)) + " m on the way";
}

/// The path as it is delivered.
void add_path(const char* log, const Trajectory& truth, Threads threads, nlohmann::json& kinds) {
  const MapResult result = map_of(log, {}, threads);
  const std::vector<Key> keys = keys_of(result, truth);
  const auto between = [&](const Key& from, const Key& to) {
    return result.covariances.between(from.node, to.node);
  };
  const auto add = [&](nlohmann::json kind) {
    if (!kind.is_null()) kinds.push_back(std::move(kind));
  };
  for (const double way_m : {0.0, 1.0, 5.0, 20.0, 80.0})
    add(judged(on_the_way(way_m), keys, apart(keys, way_m), between));
  add(judged("revisits", keys, revisits(keys), between));
}

/// What of it is the path's alone: no loop is closed, no surface shared.
void add_drift(const char* log, const Trajectory& truth, Threads threads, nlohmann::json& kinds) {
  MapOptions options{.loop_closure = false};
  options.adjustment.enabled = false;
  const MapResult result = map_of(log, options, threads);
  const std::vector<Key> keys = keys_of(result, truth);
  const auto between = [&](const Key& from, const Key& to) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (int node = from.node.index + 1; node <= to.node.index; ++node) {
      const Pose2& pose = result.graph.poses[static_cast<std::size_t>(node)];
      const Eigen::Vector2d arm = to.map_T_robot.translation() - pose.translation();
      Eigen::Matrix3d lever = Eigen::Matrix3d::Identity();
      lever(0, 2) = -arm.y();
      lever(1, 2) = arm.x();
      const auto& drift = result.drifts[static_cast<std::size_t>(node) - 1];
      sum += lever * rotated(drift.covariance, pose.rotation()) * lever.transpose();
    }
    // The noise of the matches at both ends, which does not add up.
    sum.diagonal() += 2.0 * Eigen::Vector3d(kNoiseM, kNoiseM, kNoiseRad).cwiseAbs2();
    return Eigen::Matrix3d(rotated(sum, from.map_T_robot.rotation().transpose()));
  };
  for (const double way_m : {5.0, 20.0, 80.0, 200.0}) {
    auto kind = judged("drift, " + on_the_way(way_m), keys, apart(keys, way_m), between);
    if (!kind.is_null()) kinds.push_back(std::move(kind));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "measure_covariances LOG TRUTH.tum [THREADS]\n");
    return 2;
  }
  const Threads threads{argc > 3 ? std::atoi(argv[3]) : 0};
  const Trajectory truth = read_tum(argv[2]);
  nlohmann::json kinds = nlohmann::json::array();
  add_path(argv[1], truth, threads, kinds);
  add_drift(argv[1], truth, threads, kinds);
  std::printf("%s\n", kinds.dump().c_str());
  return 0;
}
