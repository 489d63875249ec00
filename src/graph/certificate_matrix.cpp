#include "graph/certificate_matrix.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

namespace loopstone {

namespace {

using Block = ComplexBlock<2>;

void add(Block& block, int row, int column, Complex value) {
  block.re(row, column) += value.real();
  block.im(row, column) += value.imag();
}

}  // namespace

ComplexRows apply_quadratic_form(const IsotropicSystem& system, const PositionSolver& positions,
                                 const ComplexRows& rows) {
  const IsotropicProblem& problem = system.problem;
  ComplexRows result = ComplexRows::Zero(rows.rows(), rows.cols());
  std::vector<Complex> pull(problem.nodes);
  for (Eigen::Index c = 0; c < rows.cols(); ++c) {
    // Positions of least cost for this column of headings.
    std::fill(pull.begin(), pull.end(), Complex(0.0));
    for (const IsotropicEdge& edge : problem.edges) {
      const Complex step =
          edge.translation_weight * rows(static_cast<Eigen::Index>(edge.from), c) * edge.step;
      pull[edge.to] += step;
      pull[edge.from] -= step;
    }
    for (std::size_t i = 0; i < problem.nodes; ++i) {
      if (problem.anchored[i]) pull[i] = 0.0;
    }
    positions.apply_inverse(pull);
    for (const IsotropicEdge& edge : problem.edges) {
      const auto from = static_cast<Eigen::Index>(edge.from);
      const auto to = static_cast<Eigen::Index>(edge.to);
      const Complex z = rows(from, c);
      if (edge.rotation_weight > 0.0) {
        const Complex turned = edge.rotation_weight * (rows(to, c) - z * edge.turn);
        result(to, c) += turned;
        result(from, c) -= std::conj(edge.turn) * turned;
      }
      const Complex residual = pull[edge.to] - pull[edge.from] - z * edge.step;
      result(from, c) -= edge.translation_weight * std::conj(edge.step) * residual;
    }
  }
  return result;
}

RelaxedPoint relaxed_point(const IsotropicSystem& system, const PositionSolver& positions,
                           ComplexRows headings) {
  RelaxedPoint point;
  point.gradient = apply_quadratic_form(system, positions, headings);
  point.multipliers.assign(system.problem.nodes, 0.0);
  for (std::size_t i = 0; i < system.problem.headings; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    point.multipliers[i] = headings.row(row).dot(point.gradient.row(row)).real();
    point.cost += point.multipliers[i];
  }
  point.headings = std::move(headings);
  return point;
}

CertificateMatrix::CertificateMatrix(const IsotropicSystem& system)
    : system_(&system), matrix_(system.pattern) {}

bool CertificateMatrix::factorise(const std::vector<double>& multipliers, double shift) {
  const IsotropicProblem& problem = system_->problem;
  const std::vector<int>& place = system_->pattern.place;
  matrix_.set_zero();
  // The unknowns of a node: position, heading. |t_to - t_from - z_from step|^2 and |z_to - z_from
  // turn|^2 in them.
  for (std::size_t i = 0; i < problem.edges.size(); ++i) {
    const IsotropicEdge& edge = problem.edges[i];
    const double tau = edge.translation_weight;
    const double weight = edge.rotation_weight;
    const bool from_free = !problem.anchored[edge.from];
    const bool to_free = !problem.anchored[edge.to];
    Block& from = matrix_.diagonal(place[edge.from]);
    Block& to = matrix_.diagonal(place[edge.to]);
    if (from_free) {
      from.re(0, 0) += tau;
      add(from, 0, 1, tau * edge.step);
      add(from, 1, 0, tau * std::conj(edge.step));
    }
    from.re(1, 1) += tau * std::norm(edge.step) + weight;
    if (to_free) to.re(0, 0) += tau;
    to.re(1, 1) += weight;
    Block& below = matrix_.below(system_->blocks[i].index);
    if (system_->blocks[i].to_is_row) {
      if (from_free && to_free) below.re(0, 0) -= tau;
      if (to_free) add(below, 0, 1, -tau * edge.step);
      add(below, 1, 1, -weight * edge.turn);
    } else {
      if (from_free && to_free) below.re(0, 0) -= tau;
      if (to_free) add(below, 1, 0, -tau * std::conj(edge.step));
      add(below, 1, 1, -weight * std::conj(edge.turn));
    }
  }
  for (std::size_t i = 0; i < problem.nodes; ++i) {
    Block& diagonal = matrix_.diagonal(place[i]);
    if (problem.anchored[i]) diagonal.re(0, 0) = 1.0;
    if (i >= problem.headings) {
      diagonal.re(1, 1) = 1.0;
      continue;
    }
    diagonal.re(1, 1) += shift - multipliers[i];
  }
  return matrix_.factorise();
}

Eigen::VectorXcd CertificateMatrix::solve(const Eigen::VectorXcd& b) const {
  const IsotropicProblem& problem = system_->problem;
  std::vector<Block::Values> values(problem.nodes, Block::Values::Zero());
  for (std::size_t i = 0; i < problem.headings; ++i) {
    const Complex value = b(static_cast<Eigen::Index>(i));
    values[static_cast<std::size_t>(system_->pattern.place[i])].row(1) << value.real(),
        value.imag();
  }
  matrix_.solve_in_place(values);
  Eigen::VectorXcd x = Eigen::VectorXcd::Zero(b.size());
  for (std::size_t i = 0; i < problem.headings; ++i) {
    const Block::Values& value = values[static_cast<std::size_t>(system_->pattern.place[i])];
    x(static_cast<Eigen::Index>(i)) = {value(1, 0), value(1, 1)};
  }
  return x;
}

Eigenpair smallest_eigenpair(const CertificateMatrix& factorised, double shift,
                             const Eigen::VectorXcd& start, int max_steps) {
  constexpr double kEnough = 1e-6;
  std::vector<Eigen::VectorXcd> basis{start.normalized()};
  std::vector<double> diagonal;
  std::vector<double> beside;
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz;
  for (int step = 0; step < max_steps; ++step) {
    Eigen::VectorXcd next = factorised.solve(basis.back());
    diagonal.push_back(basis.back().dot(next).real());
    // Twice is enough (Kahan; Parlett 1998, section 6.9).
    for (int pass = 0; pass < 2; ++pass) {
      for (const Eigen::VectorXcd& v : basis) next -= v.dot(next) * v;
    }
    const double rest = next.norm();
    ritz.computeFromTridiagonal(
        Eigen::Map<Eigen::VectorXd>(diagonal.data(), static_cast<Eigen::Index>(diagonal.size())),
        Eigen::Map<Eigen::VectorXd>(beside.data(), static_cast<Eigen::Index>(beside.size())));
    const Eigen::Index last = ritz.eigenvalues().size() - 1;
    const double residual = rest * std::abs(ritz.eigenvectors()(last, last));
    if (residual <= kEnough * ritz.eigenvalues()(last) || step + 1 == max_steps) break;
    beside.push_back(rest);
    basis.emplace_back(next / rest);
  }
  Eigenpair result;
  const Eigen::Index last = ritz.eigenvalues().size() - 1;
  result.value = 1.0 / ritz.eigenvalues()(last) - shift;
  result.vector = Eigen::VectorXcd::Zero(start.size());
  for (Eigen::Index i = 0; i <= last; ++i) {
    result.vector += ritz.eigenvectors()(i, last) * basis[static_cast<std::size_t>(i)];
  }
  result.vector.normalize();
  return result;
}

}  // namespace loopstone
