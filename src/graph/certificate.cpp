#include "loopstone/graph/certificate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "graph/certificate_matrix.hpp"
#include "graph/certificate_verifier.hpp"
#include "graph/isotropic_descent.hpp"
#include "graph/riemannian_staircase.hpp"

namespace loopstone {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

ComplexRows as_rows(const std::vector<Complex>& headings) {
  ComplexRows rows(static_cast<Eigen::Index>(headings.size()), 1);
  for (std::size_t i = 0; i < headings.size(); ++i) {
    rows(static_cast<Eigen::Index>(i), 0) = headings[i];
  }
  return rows;
}

Certificate certificate_of(const IsotropicSystem& system, const VerifierVerdict& verdict,
                           const RelaxedPoint& point, double cost, double relative_gap,
                           std::size_t edges) {
  Certificate certificate;
  certificate.edges = edges;
  certificate.cost = cost;
  certificate.min_eigenvalue = verdict.min_eigenvalue;
  certificate.eigenvalue_tolerance = verdict.tolerance;
  // Weak duality: for any Y with unit rows tr(Y^H Q Y) = tr(Lambda) + tr(Y^H S Y) >= tr(Lambda) -
  // tolerance * rows.
  certificate.lower_bound =
      std::max(point.cost - verdict.tolerance * static_cast<double>(system.problem.headings), 0.0);
  certificate.optimality_gap = std::max(cost - certificate.lower_bound, 0.0);
  if (!verdict.shift) {
    certificate.status = CertificateStatus::kNumericalFailure;
  } else if (!verdict.positive) {
    certificate.status = CertificateStatus::kNotOptimal;
  } else if (certificate.optimality_gap <=
             relative_gap * cost +
                 verdict.tolerance * static_cast<double>(system.problem.headings)) {
    certificate.status = CertificateStatus::kCertified;
  } else {
    certificate.status = CertificateStatus::kGapOpen;
  }
  return certificate;
}

/// A component with two held poses, or a held one and priors, has measurements of its own in the
/// gauge.
bool holds_too_much(const PoseGraph& graph) {
  if (graph.fixed.size() + (graph.priors.empty() ? 0 : 1) < 2) return false;
  const GraphComponents components = connected_components(graph);
  std::vector<int> held(static_cast<std::size_t>(components.count), -1);
  for (const PosePrior& prior : graph.priors) {
    const int component = components.of_node[static_cast<std::size_t>(prior.node.index)];
    held[static_cast<std::size_t>(component)] = static_cast<int>(graph.poses.size());
  }
  for (const NodeId node : graph.fixed) {
    const int component = components.of_node[static_cast<std::size_t>(node.index)];
    int& holder = held[static_cast<std::size_t>(component)];
    if (holder != -1 && holder != node.index) return true;
    holder = node.index;
  }
  return false;
}

/// The end of a climb of the staircase: a minimum of the relaxation of some rank.
struct Climb {
  RelaxedPoint point{};
  VerifierVerdict verdict{};
  int rank = 1;
};

Climb climb(const IsotropicSystem& system, const PositionSolver& positions, Verifier& verifier,
            RelaxedPoint start, VerifierVerdict verdict, const CertificateOptions& options,
            const StopQuestion& stop) {
  Climb at{std::move(start), std::move(verdict)};
  while (!at.verdict.positive && at.verdict.shift && at.rank < options.max_rank &&
         !is_stopped(stop)) {
    const Eigenpair negative{at.verdict.min_eigenvalue, at.verdict.direction};
    RelaxedPoint lower = escape(system, positions, at.point, negative);
    if (!(lower.cost < at.point.cost)) break;
    ++at.rank;
    at.point = descend_relaxation(system, positions, verifier.matrix(), *at.verdict.shift,
                                  std::move(lower), options.max_iterations, stop);
    at.verdict = verifier.verify(at.point);
  }
  return at;
}

/// The minimum in the plane that a relaxed point leads to.
IsotropicDescentResult come_back(const IsotropicSystem& system, const PositionSolver& positions,
                                 const RelaxedPoint& point, const IsotropicState& gauge,
                                 int max_iterations, const StopQuestion& stop) {
  IsotropicState state = gauge;
  state.heading = rounded_headings(system, point, gauge.heading);
  positions.solve(state);
  return descend_isotropic(system, std::move(state), {.max_iterations = max_iterations}, stop);
}

}  // namespace

double isotropic_cost(const PoseGraph& graph) {
  const IsotropicProblem problem = isotropic_problem(graph);
  return isotropic_cost(problem, state_of(graph, problem));
}

Certificate verify_optimality(const PoseGraph& graph, const CertificateOptions& options) {
  check_graph(graph);
  const IsotropicSystem system = isotropic_system(graph);
  const IsotropicState state = state_of(graph, system.problem);
  const double cost = isotropic_cost(system.problem, state);
  if (holds_too_much(graph)) {
    return {CertificateStatus::kUnsupported, cost, 0.0, kInfinity, 0.0, cost, graph.edges.size()};
  }
  const PositionSolver positions(system);
  const RelaxedPoint point = relaxed_point(system, positions, as_rows(state.heading));
  Verifier verifier(system, options.relative_gap);
  return certificate_of(system, verifier.verify(point), point, cost, options.relative_gap,
                        graph.edges.size());
}

CertifiedSolution optimize_certified(const PoseGraph& graph, const CertificateOptions& options,
                                     const StopQuestion& stop) {
  check_graph(graph);
  const IsotropicSystem system = isotropic_system(graph);
  const IsotropicState start = state_of(graph, system.problem);
  CertifiedSolution solution{graph.poses, graph.landmarks};
  solution.cost_initial = isotropic_cost(system.problem, start);
  if (holds_too_much(graph)) {
    solution.certificate = {
        CertificateStatus::kUnsupported, solution.cost_initial, 0.0, kInfinity, 0.0,
        solution.cost_initial,           graph.edges.size()};
    return solution;
  }
  const PositionSolver positions(system);
  Verifier verifier(system, options.relative_gap);
  IsotropicDescentResult best =
      descend_isotropic(system, start, {.max_iterations = options.max_iterations}, stop);
  solution.iterations = best.iterations;

  // Each round ends in a proof or leads to a lower minimum.
  constexpr int kMostEscapes = 20;
  while (true) {
    RelaxedPoint point = relaxed_point(system, positions, as_rows(best.state.heading));
    VerifierVerdict verdict = verifier.verify(point);
    solution.certificate =
        certificate_of(system, verdict, point, best.cost, options.relative_gap, graph.edges.size());
    if (solution.certificate.status != CertificateStatus::kNotOptimal) break;
    if (options.max_rank < 2 || solution.escapes == kMostEscapes || is_stopped(stop)) break;

    const Climb top =
        climb(system, positions, verifier, std::move(point), std::move(verdict), options, stop);
    solution.rank = std::max(solution.rank, top.rank);
    IsotropicDescentResult next =
        come_back(system, positions, top.point, best.state, options.max_iterations, stop);
    solution.iterations += next.iterations;
    const bool lower = next.cost < best.cost * (1.0 - options.relative_gap);
    if (lower) {
      best = std::move(next);
      ++solution.escapes;
    }
    if (top.verdict.positive) {
      // The relaxation is solved: its value bounds every solution from below.
      solution.certificate = certificate_of(system, top.verdict, top.point, best.cost,
                                            options.relative_gap, graph.edges.size());
    }
    if (!lower) break;
  }
  if (!best.converged && !solution.certificate.certified()) {
    solution.certificate.status = CertificateStatus::kNotConverged;
  }
  PoseGraph solved = graph;
  write_state(best.state, solved);
  solution.poses = std::move(solved.poses);
  solution.landmarks = std::move(solved.landmarks);
  return solution;
}

}  // namespace loopstone
