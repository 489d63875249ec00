#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/graph/pose_graph.hpp"

namespace loopstone::test {

/// A pose graph whose true poses are known.
struct SimulatedGraph {
  PoseGraph graph;  ///< poses by dead reckoning
  std::vector<Pose2> truth;
};

struct ManhattanOptions {
  int nodes = 500;
  int blocks = 10;  ///< side of the city, in streets of 5 m
  double sigma_xy_m = 0.02;
  double sigma_yaw_rad = 0.01;
  double closure_share = 0.5;  ///< how often a revisited place is recognised
};

/// A robot that drives one metre a step through the streets of a square city and turns by 90
/// degrees at random at crossings; loop closures where it comes within 1.5 m of where it was at
/// least 10 steps before.
inline SimulatedGraph manhattan_graph(const ManhattanOptions& options, Rng rng) {
  constexpr int kBlockM = 5;
  SimulatedGraph result;
  result.truth.push_back({});
  std::map<std::pair<int, int>, std::vector<int>> visitors;
  const int half_side_m = kBlockM * options.blocks / 2;
  const auto measure = [&](int from, int to, EdgeKind kind) {
    const Pose2 noise{rng.normal(0.0, options.sigma_xy_m), rng.normal(0.0, options.sigma_xy_m),
                      rng.normal(0.0, options.sigma_yaw_rad)};
    const Pose2 true_motion = result.truth[static_cast<std::size_t>(from)].inverse() *
                              result.truth[static_cast<std::size_t>(to)];
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    information.diagonal() << std::pow(std::max(options.sigma_xy_m, 1e-3), -2.0),
        std::pow(std::max(options.sigma_xy_m, 1e-3), -2.0),
        std::pow(std::max(options.sigma_yaw_rad, 1e-3), -2.0);
    result.graph.edges.push_back({NodeId{from},
                                  NodeId{to},
                                  {true_motion.x + noise.x, true_motion.y + noise.y,
                                   wrap_angle(true_motion.yaw + noise.yaw)},
                                  information,
                                  kind});
  };
  for (int i = 0; i < options.nodes; ++i) {
    if (i > 0) {
      Pose2 next = result.truth.back() * Pose2{1.0, 0.0, 0.0};
      const bool crossing = i % kBlockM == 0;
      const bool outside =
          std::abs(next.x) > half_side_m - 0.5 || std::abs(next.y) > half_side_m - 0.5;
      if (crossing) {
        double turn = 0.5 * kPi * (static_cast<double>(rng.below(3)) - 1.0);
        if (outside) turn = rng.below(2) == 0 ? 0.5 * kPi : kPi;
        next.yaw = wrap_angle(next.yaw + turn);
      }
      result.truth.push_back(next);
      measure(i - 1, i, EdgeKind::kOdometry);
    }
    const Pose2& here = result.truth.back();
    auto& seen =
        visitors[{static_cast<int>(std::lround(here.x)), static_cast<int>(std::lround(here.y))}];
    for (std::size_t k = 0; k < seen.size() && k < 3; ++k) {
      const int before = seen[seen.size() - 1 - k];
      if (i - before >= 10 && rng.uniform() < options.closure_share) {
        measure(before, i, EdgeKind::kLoopClosure);
      }
    }
    seen.push_back(i);
  }
  result.graph.poses.assign(1, result.truth.front());
  for (const RelativePoseEdge& edge : result.graph.edges) {
    if (edge.kind == EdgeKind::kOdometry) {
      result.graph.poses.push_back(result.graph.poses.back() * edge.from_T_to);
    }
  }
  return result;
}

}  // namespace loopstone::test
