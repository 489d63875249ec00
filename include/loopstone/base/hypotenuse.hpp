#pragma once

namespace loopstone {

/// sqrt(x^2 + y^2) without overflow on the way, to within one unit in the last place, and with the
/// same bits on every processor, which std::hypot does not promise: where a fused multiply-add is
/// at hand libraries use it. Infinite when either is infinite, even beside what is not a number.
/// Source: Borges 2019, "An Improved Algorithm for hypot(a,b)", section 3 (without fused
/// multiply-add).
[[nodiscard]] double hypotenuse(double x, double y);

}  // namespace loopstone
