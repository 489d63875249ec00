#pragma once

#include <Eigen/Core>

namespace loopstone {

// Products of matrices whose sums run in one order. Eigen's own cut long ones into blocks by the
// size of the processor's caches and the number of its registers, so the last bits of a result
// depend on the machine.

/// target += sign * a * b
/// Cost: O(rows * columns * length); columns of `target` and `a` should fit into the first cache.
template <typename Target, typename A, typename B>
void add_product(Eigen::MatrixBase<Target>& target, const Eigen::MatrixBase<A>& a,
                 const Eigen::MatrixBase<B>& b, double sign) {
  for (Eigen::Index j = 0; j < b.cols(); ++j) {
    auto sums = target.col(j);
    Eigen::Index k = 0;
    for (; k + 4 <= b.rows(); k += 4) {
      sums += a.col(k) * (sign * b(k, j)) + a.col(k + 1) * (sign * b(k + 1, j)) +
              a.col(k + 2) * (sign * b(k + 2, j)) + a.col(k + 3) * (sign * b(k + 3, j));
    }
    for (; k < b.rows(); ++k) sums += a.col(k) * (sign * b(k, j));
  }
}

/// The inverse of a lower triangle; what stands above its diagonal is not read.
template <typename A>
[[nodiscard]] Eigen::MatrixXd inverse_of_lower(const Eigen::MatrixBase<A>& a) {
  const Eigen::Index size = a.rows();
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Identity(size, size);
  for (Eigen::Index j = 0; j < size; ++j) {
    for (Eigen::Index k = j; k < size; ++k) {
      inverse(k, j) /= a(k, k);
      const Eigen::Index rest = size - k - 1;
      inverse.col(j).tail(rest) -= a.col(k).tail(rest) * inverse(k, j);
    }
  }
  return inverse;
}

}  // namespace loopstone
