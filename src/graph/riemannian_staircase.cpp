#include "graph/riemannian_staircase.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace loopstone {

namespace {

/// Of real vectors with twice as many entries.
double inner(const ComplexRows& a, const ComplexRows& b) {
  return a.conjugate().cwiseProduct(b).sum().real();
}

void multiply_rows(ComplexRows& rows, const std::vector<double>& factors) {
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    rows.row(i) *= factors[static_cast<std::size_t>(i)];
}

/// What is tangent to the product of spheres at the point.
ComplexRows tangent(const RelaxedPoint& point, ComplexRows v) {
  for (Eigen::Index i = 0; i < v.rows(); ++i) {
    v.row(i) -= point.headings.row(i).dot(v.row(i)).real() * point.headings.row(i);
  }
  return v;
}

/// Half the Riemannian gradient.
ComplexRows half_gradient(const RelaxedPoint& point) {
  ComplexRows weighted = point.headings;
  multiply_rows(weighted, point.multipliers);
  return tangent(point, point.gradient - weighted);
}

ComplexRows normalised_rows(ComplexRows rows) {
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const double length = rows.row(i).norm();
    if (length > 0.0) rows.row(i) /= length;
  }
  return rows;
}

/// The trust-region subproblem at a point: minimise <g, v> + <v, H v> / 2 with half the gradient
/// and Hessian.
class Subproblem {
 public:
  Subproblem(const IsotropicSystem& system, const PositionSolver& positions,
             const CertificateMatrix& preconditioner, const RelaxedPoint& point)
      : system_(system), positions_(positions), preconditioner_(preconditioner), point_(point) {}

  struct Step {
    ComplexRows v{};
    double promise = 0.0;  ///< by how much the model is lower there, for half the cost
    bool at_border = false;
  };
  /// Steihaug's truncated conjugate gradients; `radius` in the preconditioner's norm.
  [[nodiscard]] Step solve(const ComplexRows& gradient, double radius) const;

 private:
  [[nodiscard]] ComplexRows hessian(const ComplexRows& v) const {
    ComplexRows weighted = v;
    multiply_rows(weighted, point_.multipliers);
    return tangent(point_, apply_quadratic_form(system_, positions_, v) - weighted);
  }
  [[nodiscard]] ComplexRows preconditioned(const ComplexRows& v) const {
    ComplexRows result(v.rows(), v.cols());
    for (Eigen::Index c = 0; c < v.cols(); ++c) result.col(c) = preconditioner_.solve(v.col(c));
    return tangent(point_, std::move(result));
  }

  const IsotropicSystem& system_;
  const PositionSolver& positions_;
  const CertificateMatrix& preconditioner_;
  const RelaxedPoint& point_;
};

Subproblem::Step Subproblem::solve(const ComplexRows& gradient, double radius) const {
  constexpr int kMostInner = 60;
  constexpr double kForcing = 1e-2;
  Step step{ComplexRows::Zero(gradient.rows(), gradient.cols())};
  ComplexRows residual = gradient;
  ComplexRows z = preconditioned(residual);
  ComplexRows direction = -z;
  double r_z = inner(residual, z);
  const double first = r_z;
  // Norms in the preconditioner's metric follow from recurrences (Conn, Gould and Toint 2000,
  // section 7.5.1).
  double v_v = 0.0;
  double v_d = 0.0;
  double d_d = r_z;
  for (int i = 0; i < kMostInner && r_z > 0.0; ++i) {
    const ComplexRows h_d = hessian(direction);
    const double curvature = inner(direction, h_d);
    const double alpha = r_z / curvature;
    const double next_v_v = v_v + 2.0 * alpha * v_d + alpha * alpha * d_d;
    if (!(curvature > 0.0) || next_v_v >= radius * radius) {
      const double root = std::sqrt(std::max(v_d * v_d + d_d * (radius * radius - v_v), 0.0));
      const double to_border = (root - v_d) / d_d;
      step.v += to_border * direction;
      step.promise += to_border * (r_z - 0.5 * to_border * curvature);
      step.at_border = true;
      return step;
    }
    step.v += alpha * direction;
    step.promise += 0.5 * alpha * r_z;
    v_v = next_v_v;
    residual += alpha * h_d;
    z = preconditioned(residual);
    const double next_r_z = inner(residual, z);
    if (next_r_z <= kForcing * kForcing * std::min(first, 1.0) * first) break;
    const double beta = next_r_z / r_z;
    direction = -z + beta * direction;
    v_d = beta * (v_d + alpha * d_d);
    d_d = next_r_z + beta * beta * d_d;
    r_z = next_r_z;
  }
  return step;
}

}  // namespace

RelaxedPoint descend_relaxation(const IsotropicSystem& system, const PositionSolver& positions,
                                const CertificateMatrix& preconditioner, double shift,
                                RelaxedPoint start, int max_iterations, const StopQuestion& stop) {
  constexpr double kNegligible = 1e-11;
  constexpr double kAccepted = 0.1;
  RelaxedPoint point = std::move(start);
  // The preconditioner's norm of a turn of all nodes by one radian along its weakest direction.
  const double widest = std::sqrt(shift * static_cast<double>(system.problem.headings));
  double radius = 0.5 * widest;
  for (int iteration = 0; iteration < max_iterations && !is_stopped(stop); ++iteration) {
    const ComplexRows gradient = half_gradient(point);
    const Subproblem subproblem(system, positions, preconditioner, point);
    const Subproblem::Step step = subproblem.solve(gradient, radius);
    const double promise = 2.0 * step.promise;
    if (!(promise > kNegligible * std::abs(point.cost))) break;
    RelaxedPoint trial = relaxed_point(system, positions, normalised_rows(point.headings + step.v));
    const double ratio = (point.cost - trial.cost) / promise;
    if (ratio < 0.25) {
      radius *= 0.25;
    } else if (ratio > 0.75 && step.at_border) {
      radius *= 2.0;
    }
    if (ratio > kAccepted) point = std::move(trial);
    if (radius < 1e-9 * widest) break;
  }
  return point;
}

RelaxedPoint escape(const IsotropicSystem& system, const PositionSolver& positions,
                    const RelaxedPoint& saddle, const Eigenpair& negative) {
  constexpr double kShortest = 1e-6;
  const Eigen::Index nodes = saddle.headings.rows();
  const Eigen::Index rank = saddle.headings.cols();
  // Entries of a unit vector over many nodes are small; a step of about one radian somewhere is a
  // long one.
  for (double length = 1.0 / negative.vector.cwiseAbs().maxCoeff(); length > kShortest;
       length *= 0.5) {
    ComplexRows headings(nodes, rank + 1);
    headings.leftCols(rank) = saddle.headings;
    headings.col(rank) = length * negative.vector;
    RelaxedPoint trial = relaxed_point(system, positions, normalised_rows(std::move(headings)));
    if (trial.cost < saddle.cost) return trial;
  }
  return saddle;
}

std::vector<Complex> rounded_headings(const IsotropicSystem& system, const RelaxedPoint& point,
                                      const std::vector<Complex>& anchored_headings) {
  const IsotropicProblem& problem = system.problem;
  const Eigen::Index rank = point.headings.cols();
  const auto row = [&](std::size_t i) { return point.headings.row(static_cast<Eigen::Index>(i)); };
  std::map<std::size_t, Eigen::MatrixXcd> gram_of_anchor;
  for (std::size_t i = 0; i < problem.headings; ++i) {
    const auto [gram, is_new] =
        gram_of_anchor.try_emplace(problem.anchor_of[i], Eigen::MatrixXcd::Zero(rank, rank));
    gram->second += row(i).adjoint() * row(i);
  }
  std::map<std::size_t, Eigen::VectorXcd> direction_of_anchor;
  for (const auto& [anchor, gram] : gram_of_anchor) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXcd> solver(gram);
    Eigen::VectorXcd direction = solver.eigenvectors().col(rank - 1);
    const Complex at_anchor = row(anchor) * direction;
    if (std::abs(at_anchor) > 0.0) direction *= anchored_headings[anchor] / at_anchor;
    direction_of_anchor.emplace(anchor, std::move(direction));
  }
  std::vector<Complex> headings(problem.nodes, 1.0);
  for (std::size_t i = 0; i < problem.headings; ++i) {
    const Complex value = row(i) * direction_of_anchor.at(problem.anchor_of[i]);
    const double length = std::abs(value);
    if (length > 0.0) headings[i] = value / length;
  }
  return headings;
}

}  // namespace loopstone
