#pragma once

#include "graph/certificate_matrix.hpp"
#include "loopstone/base/stop_question.hpp"

namespace loopstone {

/// A minimum of tr(Y^H Q Y) over rows of length 1, from a start of some rank: Riemannian trust
/// regions with truncated conjugate gradients (Absil, Mahony and Sepulchre 2008, algorithms 10 and
/// 11), preconditioned by a factorised S + shift I.
/// \param shift  of the preconditioner, about the size of the negative eigenvalue that is followed
[[nodiscard]] RelaxedPoint descend_relaxation(const IsotropicSystem& system,
                                              const PositionSolver& positions,
                                              const CertificateMatrix& preconditioner, double shift,
                                              RelaxedPoint start, int max_iterations,
                                              const StopQuestion& stop = {});

/// One dimension more, entered along the eigenvector of a negative eigenvalue of S: a saddle point
/// is left downwards (Rosen et al. 2019, section 5.2). The start when no step along it is
/// downwards.
[[nodiscard]] RelaxedPoint escape(const IsotropicSystem& system, const PositionSolver& positions,
                                  const RelaxedPoint& saddle, const Eigenpair& negative);

/// The headings in the plane that are nearest to a relaxed point: of each component the leading
/// singular vector, its entries brought to length 1, turned so that the anchor has the heading it
/// is given.
[[nodiscard]] std::vector<Complex> rounded_headings(const IsotropicSystem& system,
                                                    const RelaxedPoint& point,
                                                    const std::vector<Complex>& anchored_headings);

}  // namespace loopstone
