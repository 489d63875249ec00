#pragma once

#include <Eigen/Core>

namespace loopstone {

/// m * v, each sum in one order. Eigen's own depends on whether the processor has vectors of two
/// single numbers.
[[nodiscard]] inline Eigen::Vector3f product(const Eigen::Matrix3f& m, const Eigen::Vector3f& v) {
  Eigen::Vector3f sums;
  for (int i = 0; i < 3; ++i) sums[i] = m(i, 0) * v[0] + (m(i, 1) * v[1] + m(i, 2) * v[2]);
  return sums;
}

}  // namespace loopstone
