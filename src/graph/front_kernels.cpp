#include "graph/front_kernels.hpp"

#include <cmath>
#include <limits>

// Vectors of ARM's SVE have no size to the compiler, so they cannot stand in arrays; NEON is there.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "graph/front_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// What stands between the HWY_ macros is compiled for each instruction set.
HWY_BEFORE_NAMESPACE();
namespace loopstone::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, kFrontPadding>;
using Vector = hn::Vec<Doubles>;

/// The Cholesky factor of a block on the diagonal, and the inverse of its diagonal.
template <std::size_t W>
struct DiagonalBlock {
  double l[W][W];
  double inverse[W];
};

/// W columns of a matrix in the making, and the columns to the left whose products have to come
/// off.
struct Columns {
  double* target;           ///< row 0 of the first of the W columns
  const double* left_rows;  ///< row 0 of the first column to the left
  const double*
      /// in the first column to the left, the row that belongs to the first of the W columns
      left_heads;
  std::size_t target_stride;
  std::size_t left_stride;
  std::size_t left_count;
};

/// Rows [row, row + 2 vectors) or [row, row + 1 vector) of: target -= left_rows * left_heads^T;
/// then, when there is a diagonal block, target * L^-T.
template <std::size_t W, std::size_t V, bool kSubtract, bool kSolve>
HWY_INLINE void tile(const Columns& c, std::size_t row, const DiagonalBlock<W>* diagonal) {
  static_assert(V == 1 || V == 2);
  const Doubles d;
  const std::size_t lanes = hn::Lanes(d);
  Vector top[W];
  Vector bottom[W];
  for (std::size_t q = 0; q < W; ++q) {
    const double* column = c.target + q * c.target_stride + row;
    top[q] = hn::LoadU(d, column);
    if constexpr (V == 2) bottom[q] = hn::LoadU(d, column + lanes);
  }
  if constexpr (kSubtract) {
    const double* rows = c.left_rows + row;
    const double* heads = c.left_heads;
    for (std::size_t p = 0; p < c.left_count; ++p) {
      const Vector a = hn::LoadU(d, rows);
      Vector b = a;
      if constexpr (V == 2) b = hn::LoadU(d, rows + lanes);
      for (std::size_t q = 0; q < W; ++q) {
        const Vector head = hn::Set(d, heads[q]);
        top[q] = hn::Sub(top[q], hn::Mul(a, head));
        if constexpr (V == 2) bottom[q] = hn::Sub(bottom[q], hn::Mul(b, head));
      }
      rows += c.left_stride;
      heads += c.left_stride;
    }
  }
  if constexpr (kSolve) {
    for (std::size_t q = 0; q < W; ++q) {
      for (std::size_t r = 0; r < q; ++r) {
        const Vector l = hn::Set(d, diagonal->l[q][r]);
        top[q] = hn::Sub(top[q], hn::Mul(top[r], l));
        if constexpr (V == 2) bottom[q] = hn::Sub(bottom[q], hn::Mul(bottom[r], l));
      }
      const Vector inverse = hn::Set(d, diagonal->inverse[q]);
      top[q] = hn::Mul(top[q], inverse);
      if constexpr (V == 2) bottom[q] = hn::Mul(bottom[q], inverse);
    }
  }
  for (std::size_t q = 0; q < W; ++q) {
    double* column = c.target + q * c.target_stride + row;
    hn::StoreU(top[q], d, column);
    if constexpr (V == 2) hn::StoreU(bottom[q], d, column + lanes);
  }
}

template <std::size_t W, bool kSubtract, bool kSolve>
HWY_INLINE void tiles(const Columns& c, std::size_t row, std::size_t end,
                      const DiagonalBlock<W>* diagonal) {
  const std::size_t lanes = hn::Lanes(Doubles());
  for (; row + 2 * lanes <= end; row += 2 * lanes) {
    tile<W, 2, kSubtract, kSolve>(c, row, diagonal);
  }
  for (; row < end; row += lanes) tile<W, 1, kSubtract, kSolve>(c, row, diagonal);
}

/// Reads the lower triangle at the head of W columns.
template <std::size_t W>
HWY_INLINE bool factorise_diagonal(const double* head, std::size_t stride, DiagonalBlock<W>& d) {
  for (std::size_t j = 0; j < W; ++j) {
    double pivot = head[j * stride + j];
    for (std::size_t k = 0; k < j; ++k) pivot -= d.l[j][k] * d.l[j][k];
    // Also false for what is not a number.
    if (!(pivot > 0.0 && pivot <= std::numeric_limits<double>::max())) return false;
    const double root = std::sqrt(pivot);
    d.l[j][j] = root;
    d.inverse[j] = 1.0 / root;
    for (std::size_t i = j + 1; i < W; ++i) {
      double value = head[j * stride + i];
      for (std::size_t k = 0; k < j; ++k) value -= d.l[i][k] * d.l[j][k];
      d.l[i][j] = value * d.inverse[j];
    }
  }
  return true;
}

/// Left-looking: W pivots, everything to the left of which is finished.
template <std::size_t W>
HWY_INLINE bool factorise_columns(const DenseFront& front, std::size_t first) {
  const std::size_t stride = padded_rows(front.rows);
  const std::size_t lanes = hn::Lanes(Doubles());
  double* target = front.panel + first * stride;
  const Columns c{target, front.panel, front.panel + first, stride, stride, first};
  const std::size_t begin = first / lanes * lanes;
  const std::size_t beside_diagonal = (first + W + lanes - 1) / lanes * lanes;
  DiagonalBlock<W> diagonal;
  if (first > 0) tiles<W, true, false>(c, begin, beside_diagonal, nullptr);
  if (!factorise_diagonal<W>(target + first, stride, diagonal)) return false;
  for (std::size_t q = 0; q < W; ++q) front.inverse_diagonal[first + q] = diagonal.inverse[q];
  tiles<W, false, true>(c, begin, beside_diagonal, &diagonal);
  if (first > 0) {
    tiles<W, true, true>(c, beside_diagonal, stride, &diagonal);
  } else {
    tiles<W, false, true>(c, beside_diagonal, stride, &diagonal);
  }
  return true;
}

bool factorise(const DenseFront& front) {
  std::size_t pivot = 0;
  for (; pivot + 6 <= front.pivots; pivot += 6) {
    if (!factorise_columns<6>(front, pivot)) return false;
  }
  if (pivot < front.pivots && !factorise_columns<3>(front, pivot)) return false;

  const std::size_t lanes = hn::Lanes(Doubles());
  const std::size_t below = front.rows - front.pivots;
  const std::size_t stride = padded_rows(front.rows);
  const std::size_t update_stride = padded_rows(below);
  const double* left = front.panel + front.pivots;
  const auto columns = [&](std::size_t first) {
    return Columns{front.update + first * update_stride,
                   left,
                   left + first,
                   update_stride,
                   stride,
                   front.pivots};
  };
  std::size_t column = 0;
  for (; column + 6 <= below; column += 6) {
    tiles<6, true, false>(columns(column), column / lanes * lanes, update_stride, nullptr);
  }
  if (column < below) {
    tiles<3, true, false>(columns(column), column / lanes * lanes, update_stride, nullptr);
  }
  return true;
}

void solve_forward(const DenseFront& front, double* x, double* below) {
  const Doubles d;
  const std::size_t lanes = hn::Lanes(d);
  const std::size_t stride = padded_rows(front.rows);
  const std::size_t below_end = padded_rows(front.rows - front.pivots);
  for (std::size_t i = 0; i < below_end; i += lanes) hn::StoreU(hn::Zero(d), d, below + i);
  for (std::size_t p = 0; p < front.pivots; p += 3) {
    const double* l0 = front.panel + p * stride;
    const double* l1 = l0 + stride;
    const double* l2 = l1 + stride;
    const double x0 = x[p] * front.inverse_diagonal[p];
    const double x1 = (x[p + 1] - l0[p + 1] * x0) * front.inverse_diagonal[p + 1];
    const double x2 = (x[p + 2] - l0[p + 2] * x0 - l1[p + 2] * x1) * front.inverse_diagonal[p + 2];
    x[p] = x0;
    x[p + 1] = x1;
    x[p + 2] = x2;
    for (std::size_t i = p + 3; i < front.pivots; ++i) {
      x[i] -= l0[i] * x0 + l1[i] * x1 + l2[i] * x2;
    }
    const Vector v0 = hn::Set(d, x0);
    const Vector v1 = hn::Set(d, x1);
    const Vector v2 = hn::Set(d, x2);
    for (std::size_t i = 0; i < below_end; i += lanes) {
      const std::size_t row = front.pivots + i;
      const Vector sum =
          hn::Add(hn::Add(hn::Mul(hn::LoadU(d, l0 + row), v0), hn::Mul(hn::LoadU(d, l1 + row), v1)),
                  hn::Mul(hn::LoadU(d, l2 + row), v2));
      hn::StoreU(hn::Add(hn::LoadU(d, below + i), sum), d, below + i);
    }
  }
}

}  // namespace loopstone::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace loopstone {

namespace detail {
namespace {

HWY_EXPORT(factorise);
HWY_EXPORT(solve_forward);

bool factorise_dispatched(const DenseFront& front) {
  return HWY_DYNAMIC_DISPATCH(factorise)(front);
}

void solve_forward_dispatched(const DenseFront& front, double* x, double* below) {
  HWY_DYNAMIC_DISPATCH(solve_forward)(front, x, below);
}

}  // namespace
}  // namespace detail

bool factorise_front(const DenseFront& front) { return detail::factorise_dispatched(front); }

void solve_front_forward(const DenseFront& front, double* x, double* below) {
  detail::solve_forward_dispatched(front, x, below);
}

void solve_front_backward(const DenseFront& front, double* x, const double* below) {
  const std::size_t stride = padded_rows(front.rows);
  const std::size_t below_count = front.rows - front.pivots;
  for (std::size_t p = front.pivots; p > 0;) {
    p -= 3;
    const double* l0 = front.panel + p * stride;
    const double* l1 = l0 + stride;
    const double* l2 = l1 + stride;
    // Sums of even and of odd rows, so that additions need not wait for one another.
    double even[3] = {0.0, 0.0, 0.0};
    double odd[3] = {0.0, 0.0, 0.0};
    std::size_t i = 0;
    for (; i + 2 <= below_count; i += 2) {
      const std::size_t row = front.pivots + i;
      even[0] += l0[row] * below[i];
      even[1] += l1[row] * below[i];
      even[2] += l2[row] * below[i];
      odd[0] += l0[row + 1] * below[i + 1];
      odd[1] += l1[row + 1] * below[i + 1];
      odd[2] += l2[row + 1] * below[i + 1];
    }
    if (i < below_count) {
      const std::size_t row = front.pivots + i;
      even[0] += l0[row] * below[i];
      even[1] += l1[row] * below[i];
      even[2] += l2[row] * below[i];
    }
    for (std::size_t k = p + 3; k < front.pivots; ++k) {
      odd[0] += l0[k] * x[k];
      odd[1] += l1[k] * x[k];
      odd[2] += l2[k] * x[k];
    }
    const double* inverse = front.inverse_diagonal + p;
    x[p + 2] = (x[p + 2] - (even[2] + odd[2])) * inverse[2];
    x[p + 1] = (x[p + 1] - (even[1] + odd[1]) - l1[p + 2] * x[p + 2]) * inverse[1];
    x[p] = (x[p] - (even[0] + odd[0]) - l0[p + 1] * x[p + 1] - l0[p + 2] * x[p + 2]) * inverse[0];
  }
}

}  // namespace loopstone
#endif  // HWY_ONCE
