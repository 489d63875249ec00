#pragma once

#include <span>

#include "graph/block_cholesky.hpp"
#include "graph/normal_equations.hpp"
#include "loopstone/base/stop_question.hpp"
#include "loopstone/graph/solver.hpp"

namespace loopstone {

struct DescentOptions {
  DescentMethod method = DescentMethod::kGaussNewton;
  int max_iterations = 100;
  double relative_tolerance = 1e-8;
};

struct DescentResult {
  SolveStatus status = SolveStatus::kNotConverged;
  int iterations = 0;
  GraphCosts initial;
  GraphCosts final;
};

/// Lowers the robust cost of the state until nothing is left to gain, or until it is stopped.
[[nodiscard]] DescentResult descend(NormalEquations& equations, BlockCholesky& cholesky,
                                    const DescentOptions& options, GraphState& state,
                                    const StopQuestion& stop = {});

/// The state after a step, by the places of its poses and landmarks.
void apply_step(const GraphState& from, const NormalEquations& equations,
                std::span<const Eigen::Vector3d> step, GraphState& to);

}  // namespace loopstone
