#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/mapping/visit_contradiction.hpp"
#include "loopstone/slam/path_surfaces.hpp"
#include "loopstone/slam/step_drift.hpp"

namespace loopstone {

// What no second visit ties down. A map whose loop closures agree may still hold a part that hangs
// on the path alone, or on a single closure, which may be wrong by itself: a copy of a building
// beside itself contradicts nothing. So the graph is asked how far such parts may be off.

/// A part of the path along which at most one closure joins what lies before and what lies after.
struct LoosePart {
  Stamp from{};
  Stamp to{};
  double path_m = 0.0;
  int closures = 0;                                 ///< that lead across: 0 or 1
  Eigen::Vector2d where = Eigen::Vector2d::Zero();  ///< its middle, map frame [m]
  /// How far its ends may be off to one another by the path alone, one standard deviation.
  double sigma_m = 0.0;  ///< along the worst direction
  double sigma_rad = 0.0;
};

/// A part of the path along which the laser leaves a direction open: a bare corridor.
struct OpenStretch {
  Stamp from{};
  Stamp to{};
  double path_m = 0.0;
  Eigen::Vector2d where = Eigen::Vector2d::Zero();  ///< its middle, map frame [m]
  /// How far it may be too long or too short, one standard deviation: what odometry loses on the
  /// way and by its scale. No closure tells: all of a corridor's visits are as long as odometry
  /// says.
  double sigma_m = 0.0;
};

/// How far a map may be off anywhere, best aligned, all but surely (39 of 40 times).
struct PossibleError {
  double m = 0.0;
  double rad = 0.0;
};

/// How well a graph holds together.
struct GraphTies {
  PossibleError possible{};         ///< by all that is loose or open, together
  PossibleError possible_beside{};  ///< the same, were open stretches as long as the map has them
  std::vector<LoosePart> loose{};   ///< the least certain first
  std::vector<OpenStretch> open{};  ///< the least certain first
  /// How far the two visits of each contradiction may be off to one another where it is: three
  /// standard deviations by the path between them alone, and what closures and surfaces changed of
  /// it [m].
  std::vector<double> contradictions_m{};
  double variance_factor = 1.0;  ///< by which the graph's covariances were scaled
};

/// What a graph is judged by beside its edges.
struct TieEvidence {
  std::span<const Stamp> stamps{};  ///< of the graph's poses
  /// Of the path from each node to the next; where there are none, the path drifts by what its
  /// edges say.
  std::span<const StepDrift> drifts{};
  PathSurfaces surfaces{};  ///< that hold the path between its nodes; none: drifts alone count
  /// How wrong the scale of odometry may be, by which open stretches are as long as they are.
  double scale_sigma = 0.0;
  std::span<const VisitTie> agreeing{};  ///< visits that agree tie as closures do
  std::span<const VisitContradiction> contradictions{};
  int loops = 0;  ///< independent ones, and
  /// how well they close: where there are some, what the covariances promise is scaled to it, for
  /// edges are as wrong as their loops show.
  double reduced_chi2 = 1.0;
};

/// \param solved  with all edges, closures that stand among them, at its own solution
/// Cost: three factorisations of the graph at most, and the path's length times the number of
/// parts.
[[nodiscard]] GraphTies find_ties_of(const PoseGraph& solved, const TieEvidence& evidence);

}  // namespace loopstone
