#include "loopstone/base/hypotenuse.hpp"

#include <algorithm>
#include <cmath>

namespace loopstone {
namespace {

constexpr double kHuge = 0x1p+511;    // squares of more overflow
constexpr double kTiny = 0x1p-459;    // squares of less lose digits
constexpr double kScale = 0x1p+600;   // brings both back to where squares are safe
constexpr double kNothing = 0x1p-54;  // of the longer leg: half a unit in the last place

/// Of a >= b > 0 whose squares are safe: the root of the rounded sum, and one step of Newton's
/// with the error h^2 - a^2 - b^2 sorted so that little cancels.
double corrected_root(double a, double b) {
  const double h = std::sqrt(a * a + b * b);
  double error = 0.0;
  if (h <= 2.0 * b) {
    const double beyond = h - b;
    error = a * (2.0 * beyond - a) + (beyond - 2.0 * (a - b)) * beyond;
  } else {
    const double beyond = h - a;
    error = 2.0 * beyond * (a - 2.0 * b) + ((4.0 * beyond - b) * b + beyond * beyond);
  }
  return h - error / (2.0 * h);
}

}  // namespace

double hypotenuse(double x, double y) {
  const double first = std::abs(x);
  const double second = std::abs(y);
  if (std::isinf(first) || std::isinf(second)) return HUGE_VAL;
  if (std::isnan(first) || std::isnan(second)) return first + second;
  const double a = std::max(first, second);
  const double b = std::min(first, second);
  if (b <= a * kNothing) return a + b;
  if (a > kHuge) return corrected_root(a / kScale, b / kScale) * kScale;
  if (b < kTiny) return corrected_root(a * kScale, b * kScale) / kScale;
  return corrected_root(a, b);
}

}  // namespace loopstone
