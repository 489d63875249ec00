#pragma once

#include <vector>

#include "graph/isotropic_problem.hpp"

namespace loopstone {

/// What the linear steps of an isotropic problem share.
struct IsotropicSystem {
  IsotropicProblem problem;
  EliminationPattern pattern;
  std::vector<EdgeBlock> blocks;
};
[[nodiscard]] IsotropicSystem isotropic_system(const PoseGraph& graph);

/// Headings that minimise sum 2 kappa |z_to - z_from turn|^2 without |z| = 1, brought to length 1
/// afterwards; anchors keep theirs. One sparse linear solve. Martinec and Pajdla 2007, "Robust
/// rotation and translation estimation in multiview reconstruction"; Carlone et al. 2015,
/// "Initialization techniques for 3D SLAM", section III-C.
[[nodiscard]] std::vector<Complex> chordal_headings(const IsotropicSystem& system,
                                                    const std::vector<Complex>& anchored_headings);

/// For given headings the positions of least cost are the solution of a weighted graph Laplacian,
/// which does not depend on the headings: factorised once.
class PositionSolver {
 public:
  explicit PositionSolver(const IsotropicSystem& system);

  /// Anchors keep the position that the state has.
  void solve(IsotropicState& state) const;
  /// L^-1 b of the Laplacian with anchored rows and columns struck out, for nodes; b is 0 at
  /// anchors.
  void apply_inverse(std::vector<Complex>& b) const;

 private:
  const IsotropicSystem* system_;
  ConnectionCholesky<ComplexBlock<1>> laplacian_;
};

/// Chordal headings, and positions to them. Anchors stay where the graph has them.
[[nodiscard]] IsotropicState chordal_state(const IsotropicSystem& system,
                                           const PositionSolver& positions,
                                           const IsotropicState& start);

}  // namespace loopstone
