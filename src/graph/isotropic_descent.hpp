#pragma once

#include "graph/chordal.hpp"
#include "loopstone/base/stop_question.hpp"

namespace loopstone {

struct IsotropicDescentResult {
  IsotropicState state{};
  double cost = 0.0;
  int iterations = 0;      ///< steps tried
  bool converged = false;  ///< a step no longer promised to lower the cost noticeably
};

struct IsotropicDescentOptions {
  int max_iterations = 100;
  /// Stop when a Newton step promises to lower the cost by less than this share.
  double relative_tolerance = 1e-9;
};

/// A local minimum of an isotropic problem: Newton's method on positions and headings; Gauss-Newton
/// while that leads down fast from where the Hessian is not positive definite, and a damped Hessian
/// where it does not.
[[nodiscard]] IsotropicDescentResult descend_isotropic(const IsotropicSystem& system,
                                                       IsotropicState start,
                                                       const IsotropicDescentOptions& options = {},
                                                       const StopQuestion& stop = {});

}  // namespace loopstone
