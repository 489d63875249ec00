#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "graph/chordal.hpp"

namespace loopstone {

/// Rows are nodes, columns the dimensions of a relaxation; in the plane there is one.
using ComplexRows = Eigen::Matrix<Complex, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Headings of a relaxation of any rank, and what follows from them.
struct RelaxedPoint {
  ComplexRows headings{};           ///< unit rows; rows of landmarks are not used
  ComplexRows gradient{};           ///< Q headings, with positions of least cost
  std::vector<double> multipliers;  ///< Lambda: Re <headings_i, (Q headings)_i>
  double cost = 0.0;                ///< tr(headings^H Q headings) = sum of the multipliers
};

/// Q Y: the quadratic form of the problem after the positions were eliminated (Rosen et al. 2019,
/// eq. 20).
[[nodiscard]] ComplexRows apply_quadratic_form(const IsotropicSystem& system,
                                               const PositionSolver& positions,
                                               const ComplexRows& rows);
[[nodiscard]] RelaxedPoint relaxed_point(const IsotropicSystem& system,
                                         const PositionSolver& positions, ComplexRows headings);

/// S + shift I for the dual certificate S = Q - Lambda (Rosen et al. 2019, theorem 5; Carlone et
/// al. 2016, section V). Q is dense; S + shift I is the Schur complement of the sparse matrix over
/// positions and headings that is factorised here, so the one is positive definite exactly when the
/// other is (Haynsworth's inertia additivity).
class CertificateMatrix {
 public:
  explicit CertificateMatrix(const IsotropicSystem& system);

  /// Whether S + shift I is positive definite.
  [[nodiscard]] bool factorise(const std::vector<double>& multipliers, double shift);

  /// (S + shift I)^-1 b, after factorise(); rows of landmarks stay 0.
  [[nodiscard]] Eigen::VectorXcd solve(const Eigen::VectorXcd& b) const;

 private:
  const IsotropicSystem* system_;
  ConnectionCholesky<ComplexBlock<2>> matrix_;
};

struct Eigenpair {
  double value = 0.0;
  Eigen::VectorXcd vector{};  ///< of length 1
};

/// The smallest eigenvalue of S, by Lanczos on (S + shift I)^-1 with full orthogonalisation
/// (Parlett 1998, section 13).
[[nodiscard]] Eigenpair smallest_eigenpair(const CertificateMatrix& factorised, double shift,
                                           const Eigen::VectorXcd& start, int max_steps);

}  // namespace loopstone
