#pragma once

#include <limits>
#include <optional>

#include "graph/certificate_matrix.hpp"

namespace loopstone {

/// What the certificate matrix of a point of the relaxation, of any rank, tells.
struct VerifierVerdict {
  bool positive =
      false;  ///< S + tolerance I is positive definite, for the tolerance that was asked for
  double min_eigenvalue = 0.0;
  double tolerance =
      std::numeric_limits<double>::infinity();  ///< proven: no eigenvalue is below minus this
  Eigen::VectorXcd direction{};                 ///< eigenvector, when not positive
  /// Of the factorisation that the matrix holds now; nothing when there is none.
  std::optional<double> shift{};
};

/// Looks for negative eigenvalues of S at one point after the other of the same problem.
class Verifier {
 public:
  Verifier(const IsotropicSystem& system, double relative_gap)
      : system_(&system), matrix_(system), relative_gap_(relative_gap) {}

  [[nodiscard]] VerifierVerdict verify(const RelaxedPoint& point);

  /// As the last verify() left it.
  [[nodiscard]] const CertificateMatrix& matrix() const { return matrix_; }

 private:
  /// Eigenvalues above minus this count as not negative.
  [[nodiscard]] double tolerance_at(const RelaxedPoint& point) const;
  /// Shift by shift up to where S is positive definite, and from there Lanczos to its smallest
  /// eigenvalue.
  [[nodiscard]] VerifierVerdict search_negative(const RelaxedPoint& point, double tolerance);

  const IsotropicSystem* system_;
  CertificateMatrix matrix_;
  double relative_gap_;
};

}  // namespace loopstone
