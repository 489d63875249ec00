#pragma once

#include <cmath>

namespace loopstone {

/// How the cost of an edge grows with its chi2.
enum class RobustKernel { kNone, kHuber, kCauchy, kGemanMcClure };

/// What a kernel makes of a chi2: the cost rho(chi2) and the weight rho'(chi2) of the edge in the normal equations.
struct RobustValue {
  double cost = 0.0;
  double weight = 1.0;
};

/// A kernel of the given width, in standard deviations: residuals within `width` count (nearly) in full. The weight
/// depends on sqrt(chi2) / width alone, so it stays when residual and width scale together; rho(s) ~ s near zero.
/// Source: Zhang 1997, "Parameter estimation techniques", table 1, with chi2 in place of x^2.
[[nodiscard]] inline RobustValue evaluate(RobustKernel kernel, double width, double chi2) {
  const double width2 = width * width;
  const double ratio = chi2 / width2;
  switch (kernel) {
    case RobustKernel::kNone:
      break;
    case RobustKernel::kHuber: {
      if (ratio <= 1.0) break;
      const double root = std::sqrt(ratio);
      return {width2 * (2.0 * root - 1.0), 1.0 / root};
    }
    case RobustKernel::kCauchy:
      return {width2 * std::log1p(ratio), 1.0 / (1.0 + ratio)};
    case RobustKernel::kGemanMcClure:
      return {chi2 / (1.0 + ratio), 1.0 / ((1.0 + ratio) * (1.0 + ratio))};
  }
  return {chi2, 1.0};
}

}  // namespace loopstone
