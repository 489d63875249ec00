#include "graph/chordal.hpp"

#include <utility>

#include "loopstone/base/hypotenuse.hpp"

namespace loopstone {

namespace {

using Scalar = ComplexBlock<1>;

void add(Scalar& block, Complex value) {
  block.re(0, 0) += value.real();
  block.im(0, 0) += value.imag();
}

/// Solves A x = b for one complex unknown a node.
void solve_for_nodes(const ConnectionCholesky<Scalar>& factor, const std::vector<int>& place,
                     std::vector<Complex>& b) {
  std::vector<Scalar::Values> values(b.size());
  for (std::size_t i = 0; i < b.size(); ++i) {
    values[static_cast<std::size_t>(place[i])] << b[i].real(), b[i].imag();
  }
  factor.solve_in_place(values);
  for (std::size_t i = 0; i < b.size(); ++i) {
    const Scalar::Values& value = values[static_cast<std::size_t>(place[i])];
    b[i] = {value(0, 0), value(0, 1)};
  }
}

/// Adds weight |x_to - x_from factor|^2 of an edge between free nodes, or what is left of it at the
/// free one.
void add_edge(ConnectionCholesky<Scalar>& matrix, const IsotropicSystem& system, std::size_t edge,
              double weight, Complex factor) {
  const IsotropicEdge& e = system.problem.edges[edge];
  const std::vector<bool>& anchored = system.problem.anchored;
  if (!anchored[e.from]) add(matrix.diagonal(system.pattern.place[e.from]), weight);
  if (!anchored[e.to]) add(matrix.diagonal(system.pattern.place[e.to]), weight);
  if (anchored[e.from] || anchored[e.to]) return;
  // The coefficient of conj(x_to) x_from is -weight factor.
  const EdgeBlock& block = system.blocks[edge];
  add(matrix.below(block.index), -weight * (block.to_is_row ? factor : std::conj(factor)));
}

}  // namespace

IsotropicSystem isotropic_system(const PoseGraph& graph) {
  IsotropicSystem system;
  system.problem = isotropic_problem(graph);
  system.pattern = elimination_pattern(system.problem);
  system.blocks = edge_blocks(system.problem, system.pattern);
  return system;
}

std::vector<Complex> chordal_headings(const IsotropicSystem& system,
                                      const std::vector<Complex>& anchored_headings) {
  const IsotropicProblem& problem = system.problem;
  ConnectionCholesky<Scalar> matrix(system.pattern);
  std::vector<Complex> headings(problem.nodes, 0.0);
  for (std::size_t i = 0; i < problem.edges.size(); ++i) {
    const IsotropicEdge& edge = problem.edges[i];
    const double weight = edge.rotation_weight;
    if (weight == 0.0) continue;
    add_edge(matrix, system, i, weight, edge.turn);
    if (problem.anchored[edge.from] && !problem.anchored[edge.to]) {
      headings[edge.to] += weight * anchored_headings[edge.from] * edge.turn;
    }
    if (problem.anchored[edge.to] && !problem.anchored[edge.from]) {
      headings[edge.from] += weight * anchored_headings[edge.to] * std::conj(edge.turn);
    }
  }
  for (std::size_t i = 0; i < problem.nodes; ++i) {
    if (problem.anchored[i] || i >= problem.headings) {
      add(matrix.diagonal(system.pattern.place[i]), 1.0);
      headings[i] = anchored_headings[i];
    }
  }
  // A pose whose heading nothing but landmarks measures leaves a zero on the diagonal.
  if (!matrix.factorise()) return anchored_headings;
  solve_for_nodes(matrix, system.pattern.place, headings);
  for (std::size_t i = 0; i < problem.nodes; ++i) {
    const double length = hypotenuse(headings[i].real(), headings[i].imag());
    headings[i] = length > 0.0 ? headings[i] / length : Complex(1.0);
  }
  return headings;
}

PositionSolver::PositionSolver(const IsotropicSystem& system)
    : system_(&system), laplacian_(system.pattern) {
  for (std::size_t i = 0; i < system.problem.edges.size(); ++i) {
    add_edge(laplacian_, system, i, system.problem.edges[i].translation_weight, 1.0);
  }
  for (std::size_t i = 0; i < system.problem.nodes; ++i) {
    if (system.problem.anchored[i]) add(laplacian_.diagonal(system.pattern.place[i]), 1.0);
  }
  // Positive definite, since each component has an anchor and every weight is positive.
  (void)laplacian_.factorise();
}

void PositionSolver::solve(IsotropicState& state) const {
  const IsotropicProblem& problem = system_->problem;
  // Solved for the correction, so that what is anchored and what fits already stays as it is.
  std::vector<Complex> b(problem.nodes, 0.0);
  for (const IsotropicEdge& edge : problem.edges) {
    const Complex pull =
        edge.translation_weight * (state.position[edge.from] +
                                   state.heading[edge.from] * edge.step - state.position[edge.to]);
    b[edge.to] += pull;
    b[edge.from] -= pull;
  }
  for (std::size_t i = 0; i < problem.nodes; ++i) {
    if (problem.anchored[i]) b[i] = 0.0;
  }
  apply_inverse(b);
  for (std::size_t i = 0; i < problem.nodes; ++i) state.position[i] += b[i];
}

void PositionSolver::apply_inverse(std::vector<Complex>& b) const {
  solve_for_nodes(laplacian_, system_->pattern.place, b);
}

IsotropicState chordal_state(const IsotropicSystem& system, const PositionSolver& positions,
                             const IsotropicState& start) {
  IsotropicState state;
  state.heading = chordal_headings(system, start.heading);
  state.position.assign(system.problem.nodes, 0.0);
  for (std::size_t i = 0; i < system.problem.nodes; ++i) {
    if (system.problem.anchored[i]) state.position[i] = start.position[i];
  }
  positions.solve(state);
  return state;
}

}  // namespace loopstone
