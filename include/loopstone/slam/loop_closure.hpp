#pragma once

#include <Eigen/Core>
#include <compare>
#include <cstddef>
#include <optional>
#include <span>

#include "loopstone/base/words.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

/// A submap's place in the order in which they begin.
struct SubmapId {
  std::size_t index = 0;
  friend constexpr auto operator<=>(const SubmapId&, const SubmapId&) = default;

  template <typename Archive>
  void archive(Archive& a) {
    a(index);
  }
};

/// What became of a pair of submaps that looked like one place.
enum class ClosureState {
  kWaiting,   ///< it may be right; a second closure that asks for the same would settle it
  kStanding,  ///< an edge of the graph
  kRejected,  ///< it was never in the graph
  kRevoked,   ///< it was, and contradicted the rest
};

constexpr auto words_of(ClosureState /*any*/) {
  using enum ClosureState;
  return std::array{Word{kWaiting, "waiting"}, Word{kStanding, "standing"},
                    Word{kRejected, "rejected"}, Word{kRevoked, "revoked"}};
}

/// Why a closure does not stand, or by whom it does.
enum class ClosureReason {
  kNone,              ///< it stands
  kTooFewPairs,       ///< registration found too little to align
  kAmbiguousPose,     ///< another pose in the window scores nearly as well
  kAmbiguousPlace,    ///< another submap matches as well
  kTooLittleOverlap,  ///< too small a part falls where the older submap was observed
  kSurfacesDisagree,  ///< of that part, too little lies on surfaces that face the same way
  kWaitsForSecond,    ///< no second closure has asked for the same yet
  kNoSecond,          ///< and none came until the end
  kContradictsGraph,  ///< its residual is too large to be chance
  kSurroundings,      ///< the submaps around both ends do not hold it where it bends the map
  kAddedByHand,       ///< it stands: somebody said so
  kDeletedByHand,     ///< it stood until somebody said no
  kIgnored,           ///< without scans that are not to be used, too little is left of it
};

/// Without comma or quote.
constexpr auto words_of(ClosureReason /*any*/) {
  using enum ClosureReason;
  return std::array{Word{kNone, ""},
                    Word{kTooFewPairs, "refinement found too few pairs"},
                    Word{kAmbiguousPose, "ambiguous: another pose scores nearly as well"},
                    Word{kAmbiguousPlace, "ambiguous: another place matches as well"},
                    Word{kTooLittleOverlap, "too little overlap"},
                    Word{kSurfacesDisagree, "surfaces disagree"},
                    Word{kWaitsForSecond, "waits for a second closure that asks for the same"},
                    Word{kNoSecond, "no second closure asks for the same"},
                    Word{kContradictsGraph, "revoked: contradicts the rest of the graph"},
                    Word{kSurroundings, "the places around do not bear it out"},
                    Word{kAddedByHand, "added by hand"},
                    Word{kDeletedByHand, "deleted by hand"},
                    Word{kIgnored, "its scans are ignored"}};
}

/// A place that was recognised, or looked like it, with the evidence.
struct LoopClosure {
  /// Nodes of the graph: of its submaps while the robot drives, of its key scans in a finished map.
  NodeId from{};
  NodeId to{};
  SubmapId from_submap{};                                ///< the older one
  SubmapId to_submap{};                                  ///< the newer one
  Pose2 from_T_to{};                                     ///< as measured by registration
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of from_T_to, (x, y, yaw)
  bool by_appearance = false;  ///< its window was laid by what both look like: no pose vouches
  double score = 0.0;          ///< [0, 1], share of points explained
  /// Best score elsewhere in the window, where one came near `score`.
  std::optional<double> second_score{};
  double overlap = 0.0;  ///< [0, 1], share of points that fall where the older one was observed
  /// [0, 1], of those, share on a surface facing the same way; or, where that is more, of each
  /// submap's surfaces that the other one could see, share that it saw (docs/pipeline.md).
  double agreement = 0.0;
  /// Disagreement with the graph's poses; of what was never in the graph, nothing.
  std::optional<double> chi2{};
  ClosureState state = ClosureState::kRejected;
  ClosureReason reason = ClosureReason::kNone;

  [[nodiscard]] bool stands() const { return state == ClosureState::kStanding; }

  template <typename Archive>
  void archive(Archive& a) {
    a(from, to, from_submap, to_submap, from_T_to, covariance, by_appearance, score, second_score,
      overlap, agreement, chi2, state, reason);
  }
};

/// The edge that a closure adds to a graph: its nodes are `from` and `to`.
[[nodiscard]] RelativePoseEdge edge_of(const LoopClosure& closure);
/// Its disagreement with a graph. \param poses  of the graph's nodes
[[nodiscard]] double chi2_at(const LoopClosure& closure, std::span<const Pose2> poses);

}  // namespace loopstone
