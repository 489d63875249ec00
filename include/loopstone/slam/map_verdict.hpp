#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "loopstone/base/words.hpp"
#include "loopstone/graph/certificate.hpp"
#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/mapping/visit_contradiction.hpp"
#include "loopstone/slam/loop_closure.hpp"

namespace loopstone {

struct MapResult;

enum class Verdict {
  kUnknown,  ///< nothing was measured that could tell
  kGood,
  kDoubtful,
  kBad,
};

constexpr auto words_of(Verdict /*any*/) {
  using enum Verdict;
  return std::array{Word{kUnknown, "unknown"}, Word{kGood, "good"}, Word{kDoubtful, "doubtful"},
                    Word{kBad, "bad"}};
}

/// What the pose graph says about itself.
struct GraphQuality {
  int loops = 0;  ///< independent ones: edges less nodes plus 1
  double reduced_chi2 =
      /// sum of e^T Omega e a degree of freedom (3 a loop); 1 is what the covariances promise
      0.0;
  int closures_revoked = 0;  ///< that had been accepted and contradicted the rest
  int closures = 0;          ///< accepted or revoked
  /// Of the isotropic objective (certificate.hpp), from the graph's poses; nothing when the graph
  /// has no loop or is too large.
  std::optional<Certificate> certificate{};
  /// Whether it is proven that no solution is cheaper by more than a hundredth. In large graphs
  /// rounding keeps the bound from closing; a solution of another shape costs many times as much.
  [[nodiscard]] bool is_proven() const;
  /// Largest distance of a node, best aligned, of the graph's solution from where the solver
  /// arrives when it begins at the proven optimum.
  double certified_shift_m = 0.0;
  /// Of the delivered map from the graph's solution: what the adjustment to surfaces made of it.
  double adjusted_shift_m = 0.0;
};

/// \param solved     all edges, closures that stand among them, at the graph's own solution
/// \param delivered  the poses of the map: the solution, or what an adjustment made of it
/// Cost: a few sparse factorisations of the graph.
[[nodiscard]] GraphQuality assess_graph(const PoseGraph& solved, std::span<const Pose2> delivered,
                                        std::span<const LoopClosure> closures);

/// One figure and what it means.
struct QualityMeasure {
  std::string name;   ///< unit at its end, as in summary.json
  std::string title;  ///< in words
  double value = 0.0;
  Verdict verdict = Verdict::kUnknown;
  std::string sentence;       ///< plain words
  bool said_of_good = false;  ///< what it says is to be known of a good map, too
};

/// How good a map is, as far as its own scans can tell.
struct MapVerdict {
  Verdict overall = Verdict::kUnknown;
  std::string sentence;
  std::vector<QualityMeasure> measures{};  ///< always the same ones, in the same order
};

/// Turns the figures of quality, graph_quality and statistics into words. The thresholds come from
/// what the figures mean, and were checked on simulated runs that were spoiled on purpose
/// (bench/quality.py, docs/quality.md). Overall: the worst of what is known.
[[nodiscard]] MapVerdict judge_map(const MapResult& result);

/// Whether a region is more than what moved between two visits (doors, chairs, people): so it
/// counts in the verdict.
[[nodiscard]] bool is_contradiction(const VisitContradiction& region);

/// Adds what the map can't know: which share [0, 1] of the log, of its scans or of its records,
/// could not be used. A map of the rest may be right and still not be the map of that drive. Does
/// nothing when there is no verdict.
void judge_left_out(MapVerdict& verdict, double share);

}  // namespace loopstone
