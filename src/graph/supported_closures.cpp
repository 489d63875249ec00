#include "graph/supported_closures.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>

#include "graph/closure_loops.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {

namespace {

/// What the others say about a closure.
struct Backing {
  double compared = 0.0;  ///< how many could have backed it
  double narrowest =
      std::numeric_limits<double>::infinity();  ///< least determinant of those that do
};

}  // namespace

std::vector<bool> supported_closures(const PoseGraph& graph, double consistent_chi2,
                                     double accident) {
  const ClosureLoops loops(graph);
  const std::vector<ComparedClosure>& closures = loops.closures();
  std::vector<bool> supported(graph.edges.size(), false);
  if (closures.empty()) return supported;

  Eigen::AlignedBox2d extent;
  for (const Pose2& pose : loops.poses()) extent.extend(pose.translation());
  const double poses_m2_rad = std::max(extent.volume(), 1.0) * 2.0 * kPi;
  // An accident hits an ellipsoid of volume 4/3 pi chi2^1.5 sqrt(det).
  const double hits = 4.0 / 3.0 * kPi * std::pow(consistent_chi2, 1.5);
  const double widest = accident * poses_m2_rad / hits;
  const double most_determinant = widest * widest;

  std::vector<std::size_t> by_start(closures.size());
  std::iota(by_start.begin(), by_start.end(), std::size_t{0});
  std::stable_sort(by_start.begin(), by_start.end(), [&](std::size_t a, std::size_t b) {
    return closures[a].from < closures[b].from;
  });
  std::vector<Backing> backing(closures.size());
  for (std::size_t i = 0; i < by_start.size(); ++i) {
    const ComparedClosure& a = closures[by_start[i]];
    for (std::size_t k = i + 1; k < by_start.size(); ++k) {
      const ComparedClosure& b = closures[by_start[k]];
      if (!loops.joined(a, b)) continue;
      // The covariance is no less than either stretch of odometry, and the first of them grows with
      // k.
      if (loops.stretch(a.from, b.from).determinant() > most_determinant) break;
      if (loops.stretch(a.to, b.to).determinant() > most_determinant) continue;
      const ClosureLoops::Opening opening = loops.opening(a, b);
      if (opening.determinant > most_determinant) continue;
      const bool agree = opening.chi2 <= consistent_chi2;
      for (const std::size_t closure : {by_start[i], by_start[k]}) {
        ++backing[closure].compared;
        if (agree)
          backing[closure].narrowest = std::min(backing[closure].narrowest, opening.determinant);
      }
    }
  }
  for (std::size_t i = 0; i < closures.size(); ++i) {
    supported[closures[i].edge] =
        backing[i].compared * hits * std::sqrt(backing[i].narrowest) <= accident * poses_m2_rad;
  }
  return supported;
}

}  // namespace loopstone
