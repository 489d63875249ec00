#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "loopstone/base/options.hpp"
#include "loopstone/base/stop_question.hpp"
#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/graph/solver.hpp"

namespace loopstone {

/// Loop closures are judged, all other edges are trusted.
struct GncOptions {
  double inlier_chi2 = 25.902;
  double sharpening = 1.4;
  int max_rounds = 200;
  bool start_from_odometry = true;
  bool consistency_first = false;
};

template <typename Visitor>
void visit_options(GncOptions& options, Visitor&& visit) {
  visit("inlier_chi2", options.inlier_chi2, Range{0.1, 1e6},
        "squared standard deviations that a true loop closure may be off; 25.902: 0.99999 of a "
        "chi-square with 3 degrees of freedom");
  visit("sharpening", options.sharpening, Range{1.01, 10.0},
        "by how much outliers are told apart more sharply from round to round");
  visit("max_rounds", options.max_rounds, Range{1, 10000}, "stop after so many rounds");
  visit("start_from_odometry", options.start_from_odometry,
        "start from the chain of odometry edges, not from the graph's poses");
  visit("consistency_first", options.consistency_first,
        "begin with the loop closures that agree with one another");
}

struct GncResult {
  SolveResult solved;             ///< with the accepted closures alone; edge_weights hold 1 or 0
  std::vector<double> edge_chi2;  ///< of every edge at the solution, which says why it was rejected
  std::size_t accepted = 0;       ///< loop closures
  std::size_t rejected = 0;
  int rounds = 0;
};

/// Poses from measurements of which many loop closures may be wrong: truncated least squares,
/// approached from a convex cost by graduated non-convexity.
///
/// Many false closures make the factor dense, so where there are more than 200 closures the rounds
/// are run with those alone that another one backs: the loop of both and the odometry between them
/// closes, more narrowly than accident would have it.
///
/// The rounds judge a closure by its own residual, which is small where a long, soft chain of
/// odometry gives way to a false one. So at the end each closure is judged once more by what the
/// others say (Baarda 1968, data snooping): those whose removal lowers the cost by more than
/// inlier_chi2 go, those that agree with the prediction from the rest come back. The bound is
/// tightened where the accepted closures agree far better than their information promises. Other
/// starts (odometry alone, consistent closures) compete by truncated cost where there are few
/// closures, or where the result's cost is more than twice its degrees of freedom.
///
/// \param stop  asked before each round and step; true ends it: then the poses and weights mean
///              nothing, and the status is kNotConverged
/// Source: Yang, Antonante, Tzoumas and Carlone 2020, "Graduated non-convexity for robust spatial
/// perception".
[[nodiscard]] GncResult optimize_gnc(const PoseGraph& graph, const GncOptions& options = {},
                                     const SolverOptions& solver = {},
                                     const StopQuestion& stop = {});

struct ConsistencyOptions {
  /// Squared standard deviations that the loop of two true closures and the odometry between them
  /// may be open.
  double consistent_chi2 = 11.345;
  /// Up to this many closures the greatest set is found exactly; beyond, by a greedy search that
  /// may miss it.
  int exact_up_to = 150;
};

struct ConsistentClosures {
  std::vector<std::size_t> edges;  ///< indices of the closures in the greatest set found
  bool exact = false;              ///< proven to be the greatest
};

/// The greatest set of loop closures that all agree pairwise, given the odometry: a maximum clique
/// of the graph of consistent pairs. Needs odometry edges between consecutive poses; closures at
/// poses without are left out.
/// Cost: O(closures^2). Source: Mangelson et al. 2018, "Pairwise consistent measurement set
/// maximization for robust multi-robot map merging"; exact cliques by Tomita and Seki 2003, greedy
/// ones by Pattabiraman et al. 2015.
[[nodiscard]] ConsistentClosures consistent_closures(const PoseGraph& graph,
                                                     const ConsistencyOptions& options = {});

/// A greatest clique of an undirected graph, as ascending nodes. `adjacent[i][j]` is symmetric.
struct Clique {
  std::vector<int> nodes;
  bool exact = false;
};
[[nodiscard]] Clique greatest_clique(const std::vector<std::vector<bool>>& adjacent,
                                     int exact_up_to);

}  // namespace loopstone
