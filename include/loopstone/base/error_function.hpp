#pragma once

namespace loopstone {

/// 2 / sqrt(pi) times the integral of exp(-t^2) from 0 to x, within 1e-15 of its value. It is made
/// of sums, products, quotients and std::exp, so that it does not depend on how a library's own was
/// compiled, as std::erf does.
/// Source: Cody 1969, "Rational Chebyshev approximations for the error function".
[[nodiscard]] double error_function(double x);

/// 1 - error_function(x), as precise where that is small. Source: as above.
[[nodiscard]] double complementary_error_function(double x);

}  // namespace loopstone
