#pragma once

#include <span>
#include <vector>

#include "loopstone/base/options.hpp"
#include "loopstone/base/parallel_for.hpp"
#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/sensor/scan_points.hpp"
#include "loopstone/slam/path_surfaces.hpp"
#include "loopstone/slam/pose_covariances.hpp"

namespace loopstone {

struct SurfaceAdjustmentOptions {
  bool enabled = true;
  double patch_m = 0.2;
  int rounds = 6;
  int points_max = 120;
};

template <typename Visitor>
void visit_options(SurfaceAdjustmentOptions& options, Visitor&& visit) {
  visit("enabled", options.enabled,
        "after the graph, move all key scans jointly onto the surfaces that they share");
  visit("patch_m", options.patch_m, Range{0.02, 2.0},
        "surfaces within a cell of this size are taken for one straight line");
  visit("rounds", options.rounds, Range{1, 50},
        "of looking anew which key scans see the same surface");
  visit("points_max", options.points_max, Range{10, 10000}, "points of a key scan that are used");
}

struct SurfaceAdjustment {
  std::vector<Pose2> poses{};                ///< of the graph, adjusted
  std::vector<Eigen::Vector2d> landmarks{};  ///< the same
  /// Of points about the surfaces that key scans share: the standard deviation of most of them,
  /// 1.48 times the median.
  double spread_before_m = 0.0;
  double spread_after_m = 0.0;
  int rounds = 0;                 ///< Gauss-Newton steps taken
  PoseCovariances covariances{};  ///< of the poses
  PathSurfaces path{};            ///< what surfaces say of it where no visit ties another
  int products = 0;               ///< matrix times vector, in all of their conjugate gradients
};

/// Bundle adjustment of a map of lines: all key-scan poses and all surface patches at once,
///
///   minimise  sum_i w_i rho( (n_c^T (T_k p_i) - d_c - s_c t_i) / sigma )  +  the graph's own cost
///
/// over the poses T_k and, for each patch c of surface that several key scans saw, its offset d_c
/// and slope s_c; rho is Cauchy's, sigma comes from the residuals. Patches are eliminated in closed
/// form; what remains is solved by conjugate gradients with two preconditioners: the graph's
/// factor, and one of stretches of key scans as rigid bodies.
///
/// \param graph     its poses are the start, good to about half a patch; held poses stay; its edges
///                  hold what surfaces leave open (a corridor's axis)
/// \param surfaces  of each pose, its own frame [m]
/// \param weakness  of the path to each pose: there surfaces do not hold it by themselves
/// \return the poses, no worse than the graph's: a round that does not lower the spread is not
///         taken.
/// Throws UsageError unless there are as many scans as poses, and as check_graph does.
/// Cost: O(points) a product, about 15 products. The same bytes for any number of threads.
/// Source: Liu and Zhang 2021, "BALM: Bundle adjustment for lidar mapping", in the plane; Triggs et
/// al. 2000, "Bundle adjustment - a modern synthesis", section 6, for the elimination of what is
/// seen.
[[nodiscard]] SurfaceAdjustment adjust_to_surfaces(
    const PoseGraph& graph, std::span<const std::vector<SurfacePoint>> surfaces,
    const SurfaceAdjustmentOptions& options = {}, Threads threads = {},
    const PathWeakness& weakness = {});

}  // namespace loopstone
