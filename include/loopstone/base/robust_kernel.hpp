#pragma once

#include <cmath>

#include "loopstone/base/words.hpp"

namespace loopstone {

/// How the cost of a residual grows with its chi2.
enum class RobustKernel { kNone, kHuber, kCauchy, kGemanMcClure, kTukey, kDcs };

constexpr auto words_of(RobustKernel /*any*/) {
  using enum RobustKernel;
  return std::array{Word{kNone, "none"},     Word{kHuber, "huber"},
                    Word{kCauchy, "cauchy"}, Word{kGemanMcClure, "geman_mcclure"},
                    Word{kTukey, "tukey"},   Word{kDcs, "dcs"}};
}

/// What a kernel makes of a chi2: the cost rho(chi2) and the weight rho'(chi2) of the residual in
/// the normal equations.
struct RobustValue {
  double cost = 0.0;
  double weight = 1.0;
};

/// A kernel of the given width, in the residual's units: residuals within `width` count (nearly) in
/// full. The weight depends on sqrt(chi2) / width alone, so it stays when residual and width scale
/// together; rho(s) ~ s near zero. Beyond the width Tukey's weight is 0: such residuals say nothing
/// at all.
/// Source: Zhang 1997, "Parameter estimation techniques", table 1, with chi2 in place of x^2; DCS:
/// Agarwal et al. 2013, "Robust map optimization using dynamic covariance scaling", in closed form.
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
    case RobustKernel::kTukey: {
      if (ratio >= 1.0) return {width2 / 3.0, 0.0};
      const double rest = 1.0 - ratio;
      return {width2 / 3.0 * (1.0 - rest * rest * rest), rest * rest};
    }
    case RobustKernel::kDcs: {
      // s = 2 phi / (phi + chi2), phi = width^2; the weight is s^2.
      if (ratio <= 1.0) break;
      const double scale = 2.0 / (1.0 + ratio);
      return {width2 * (3.0 * ratio - 1.0) / (1.0 + ratio), scale * scale};
    }
  }
  return {chi2, 1.0};
}

}  // namespace loopstone
