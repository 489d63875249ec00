#pragma once

#include <cstddef>

namespace loopstone {

/// Doubles to which a column of a dense front is padded; the vectors of the kernels are never
/// wider.
inline constexpr std::size_t kFrontPadding = 4;
/// Doubles that may be read behind a front's last column.
inline constexpr std::size_t kFrontSlack = 8;

[[nodiscard]] constexpr std::size_t padded_rows(std::size_t rows) {
  return (rows + kFrontPadding - 1) / kFrontPadding * kFrontPadding;
}

/// The dense part of a front, column by column: `pivots` columns of `rows` rows (lower trapezoid;
/// what stands above the diagonal is scratch), and the square that is left for the parent, rows -
/// pivots wide (lower triangle). Columns are padded_rows(rows) and padded_rows(rows - pivots)
/// apart. Both counts are multiples of 3.
struct DenseFront {
  double* panel = nullptr;
  double* update = nullptr;
  double* inverse_diagonal = nullptr;  ///< 1 / L_jj of the pivots
  std::size_t rows = 0;
  std::size_t pivots = 0;
};

/// Factorises the pivots in place and takes their outer product off the update. False when a pivot
/// is not positive. Products and sums are rounded one by one and no sum depends on the vector
/// width, so every processor gives the same bytes.
[[nodiscard]] bool factorise_front(const DenseFront& front);

/// Forward substitution through a front: x of the pivots in place, `below` (rows - pivots, padded)
/// receives what is to be taken off the rows below.
void solve_front_forward(const DenseFront& front, double* x, double* below);

/// Back substitution: x of the pivots in place, given the solution at the rows below (padded,
/// padding zero).
void solve_front_backward(const DenseFront& front, double* x, const double* below);

}  // namespace loopstone
