#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include "graph/connection_cholesky.hpp"
#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

using Complex = std::complex<double>;

/// A measurement between two nodes of an isotropic problem; headings and positions are complex
/// numbers.
struct IsotropicEdge {
  std::size_t from = 0;
  std::size_t to = 0;
  double rotation_weight = 0.0;     ///< 2 kappa; 0 for a landmark, which has no heading
  double translation_weight = 0.0;  ///< tau
  Complex turn = 1.0;               ///< heading of `to` seen from `from`
  Complex step = 0.0;               ///< position of `to` seen from `from` [m]
};

/// F(z, t) = sum over edges of 2 kappa |z_to - z_from turn|^2 + tau |t_to - t_from - z_from
/// step|^2, |z| = 1: the objective of SE-Sync (Rosen et al. 2019, problem 1) in the plane, where a
/// rotation matrix is a complex number and |R|_F^2 = 2 |z|^2. Carlone, Calafiore, Tommolillo and
/// Dellaert 2016, "Planar pose graph optimization: duality, optimal solutions, and verification",
/// eq. 11.
struct IsotropicProblem {
  std::size_t poses = 0;  ///< the first nodes, in the graph's order
  std::size_t headings =
      0;  ///< nodes that have a heading: the poses, and the map when there are priors
  std::size_t nodes = 0;  ///< the landmarks come last
  std::vector<IsotropicEdge> edges{};
  std::vector<std::size_t> anchor_of{};  ///< the node that gives a node's component its frame
  std::vector<bool> anchored{};          ///< one flag a node: it is an anchor
};

struct IsotropicState {
  std::vector<Complex> heading{};   ///< 1 for landmarks
  std::vector<Complex> position{};  ///< [m]
};

/// kappa = I33 and tau = 2 / tr((I_tt)^-1), as SE-Sync's reader has them; a prior is an edge from
/// the map.
[[nodiscard]] IsotropicProblem isotropic_problem(const PoseGraph& graph);

/// The graph's poses and landmarks.
[[nodiscard]] IsotropicState state_of(const PoseGraph& graph, const IsotropicProblem& problem);

/// The other way round.
void write_state(const IsotropicState& state, PoseGraph& graph);

[[nodiscard]] double isotropic_cost(const IsotropicProblem& problem, const IsotropicState& state);

[[nodiscard]] EliminationPattern elimination_pattern(const IsotropicProblem& problem);

/// Where the contribution of each edge lies in the factor: index of its block, and whether `to` is
/// its row.
struct EdgeBlock {
  std::size_t index = 0;
  bool to_is_row = true;
};
[[nodiscard]] std::vector<EdgeBlock> edge_blocks(const IsotropicProblem& problem,
                                                 const EliminationPattern& pattern);

}  // namespace loopstone
