#include "graph/certificate_verifier.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {

namespace {

/// Something that no eigenvector is orthogonal to: entries of length 1 in directions that do not
/// repeat.
Eigen::VectorXcd mixed_start(const IsotropicProblem& problem) {
  constexpr double kGoldenAngle = 2.399963229728653;
  Eigen::VectorXcd start = Eigen::VectorXcd::Zero(static_cast<Eigen::Index>(problem.nodes));
  for (std::size_t i = 0; i < problem.headings; ++i) {
    const double k = static_cast<double>(i) + 1.0;
    start(static_cast<Eigen::Index>(i)) =
        std::polar(1.0, std::fmod(kGoldenAngle * k * k, 2.0 * kPi));
  }
  return start;
}

}  // namespace

double Verifier::tolerance_at(const RelaxedPoint& point) const {
  // Rounding of a factorisation moves eigenvalues by a multiple of machine epsilon times the
  // largest entries.
  constexpr double kRounding = 1e-13;
  double scale = 0.0;
  for (const double multiplier : point.multipliers) scale = std::max(scale, std::abs(multiplier));
  for (const IsotropicEdge& edge : system_->problem.edges) {
    scale = std::max(scale, edge.rotation_weight + edge.translation_weight * std::norm(edge.step));
  }
  const double headings = static_cast<double>(std::max<std::size_t>(system_->problem.headings, 1));
  return std::max(0.5 * relative_gap_ * point.cost / headings, kRounding * scale);
}

VerifierVerdict Verifier::verify(const RelaxedPoint& point) {
  constexpr int kConfirmingSteps = 3;
  const double tolerance = tolerance_at(point);
  if (!matrix_.factorise(point.multipliers, tolerance)) return search_negative(point, tolerance);
  // The headings themselves are an eigenvector with eigenvalue 0; something else is mixed in to see
  // lower ones.
  Eigen::VectorXcd start = mixed_start(system_->problem);
  for (std::size_t i = 0; i < system_->problem.headings; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    start(row) = 0.1 * start(row) + point.headings(row, 0);
  }
  VerifierVerdict verdict;
  verdict.positive = true;
  verdict.min_eigenvalue = smallest_eigenpair(matrix_, tolerance, start, kConfirmingSteps).value;
  verdict.tolerance = tolerance;
  verdict.shift = tolerance;
  return verdict;
}

VerifierVerdict Verifier::search_negative(const RelaxedPoint& point, double tolerance) {
  constexpr int kSteps = 60;
  constexpr double kGrowth = 30.0;
  double largest = 0.0;
  for (const double multiplier : point.multipliers) {
    largest = std::max(largest, std::abs(multiplier));
  }
  // Q is positive semidefinite, so S + shift I is positive definite from the largest multiplier on.
  VerifierVerdict verdict;
  for (double shift = kGrowth * tolerance; shift < kGrowth * (2.0 * largest + tolerance) * kGrowth;
       shift *= kGrowth) {
    if (!matrix_.factorise(point.multipliers, shift)) continue;
    Eigenpair pair = smallest_eigenpair(matrix_, shift, mixed_start(system_->problem), kSteps);
    verdict.min_eigenvalue = pair.value;
    verdict.direction = std::move(pair.vector);
    verdict.tolerance = shift;
    verdict.shift = shift;
    return verdict;
  }
  return verdict;
}

}  // namespace loopstone
