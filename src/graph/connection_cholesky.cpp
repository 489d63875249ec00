#include "graph/connection_cholesky.hpp"

#include <algorithm>
#include <cmath>

#include "graph/elimination_order.hpp"

namespace loopstone {

namespace {

constexpr int kNone = -1;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

// c -= a b^H
template <int kSize>
inline void subtract_product(ComplexBlock<kSize>& c, const ComplexBlock<kSize>& a,
                             const ComplexBlock<kSize>& b) {
  c.re.noalias() -= a.re.lazyProduct(b.re.transpose());
  c.re.noalias() -= a.im.lazyProduct(b.im.transpose());
  c.im.noalias() -= a.im.lazyProduct(b.re.transpose());
  c.im.noalias() += a.re.lazyProduct(b.im.transpose());
}

template <int kSize>
inline void subtract_product(RealBlock<kSize>& c, const RealBlock<kSize>& a,
                             const RealBlock<kSize>& b) {
  c.re.noalias() -= a.re.lazyProduct(b.re.transpose());
}

// a b^H
template <int kSize>
inline ComplexBlock<kSize> times_adjoint(const ComplexBlock<kSize>& a,
                                         const ComplexBlock<kSize>& b) {
  ComplexBlock<kSize> c;
  c.re.noalias() = a.re.lazyProduct(b.re.transpose()) + a.im.lazyProduct(b.im.transpose());
  c.im.noalias() = a.im.lazyProduct(b.re.transpose()) - a.re.lazyProduct(b.im.transpose());
  return c;
}

template <int kSize>
inline RealBlock<kSize> times_adjoint(const RealBlock<kSize>& a, const RealBlock<kSize>& b) {
  RealBlock<kSize> c;
  c.re.noalias() = a.re.lazyProduct(b.re.transpose());
  return c;
}

// y -= a x for vectors of real and imaginary parts
template <int kSize>
inline void subtract_applied(typename ComplexBlock<kSize>::Values& y, const ComplexBlock<kSize>& a,
                             const typename ComplexBlock<kSize>::Values& x) {
  y.col(0) -= a.re * x.col(0) - a.im * x.col(1);
  y.col(1) -= a.im * x.col(0) + a.re * x.col(1);
}

template <int kSize>
inline void subtract_applied(typename RealBlock<kSize>::Values& y, const RealBlock<kSize>& a,
                             const typename RealBlock<kSize>::Values& x) {
  y -= a.re * x;
}

// y -= a^H x
template <int kSize>
inline void subtract_adjoint_applied(typename ComplexBlock<kSize>::Values& y,
                                     const ComplexBlock<kSize>& a,
                                     const typename ComplexBlock<kSize>::Values& x) {
  y.col(0) -= a.re.transpose() * x.col(0) + a.im.transpose() * x.col(1);
  y.col(1) -= a.re.transpose() * x.col(1) - a.im.transpose() * x.col(0);
}

template <int kSize>
inline void subtract_adjoint_applied(typename RealBlock<kSize>::Values& y,
                                     const RealBlock<kSize>& a,
                                     const typename RealBlock<kSize>::Values& x) {
  y -= a.re.transpose() * x;
}

bool invert_factor(ComplexBlock<1>& a) {
  const double pivot = a.re(0, 0);
  if (!(pivot > 0.0) || !std::isfinite(pivot)) return false;
  a.re(0, 0) = 1.0 / std::sqrt(pivot);
  a.im(0, 0) = 0.0;
  return true;
}

bool invert_factor(ComplexBlock<2>& a) {
  const double d0 = a.re(0, 0);
  if (!(d0 > 0.0)) return false;
  const double i0 = 1.0 / std::sqrt(d0);
  const double l_re = a.re(1, 0) * i0;
  const double l_im = a.im(1, 0) * i0;
  const double d1 = a.re(1, 1) - l_re * l_re - l_im * l_im;
  if (!(d1 > 0.0) || !std::isfinite(d1)) return false;
  const double i1 = 1.0 / std::sqrt(d1);
  a.re << i0, 0.0, -l_re * i0 * i1, i1;
  a.im << 0.0, 0.0, -l_im * i0 * i1, 0.0;
  return true;
}

bool invert_factor(RealBlock<3>& a) {
  Eigen::Matrix3d& m = a.re;
  const double d0 = m(0, 0);
  if (!(d0 > 0.0)) return false;
  const double i0 = 1.0 / std::sqrt(d0);
  const double l10 = m(1, 0) * i0;
  const double l20 = m(2, 0) * i0;
  const double d1 = m(1, 1) - l10 * l10;
  if (!(d1 > 0.0)) return false;
  const double i1 = 1.0 / std::sqrt(d1);
  const double l21 = (m(2, 1) - l20 * l10) * i1;
  const double d2 = m(2, 2) - l20 * l20 - l21 * l21;
  if (!(d2 > 0.0) || !std::isfinite(d2)) return false;
  const double i2 = 1.0 / std::sqrt(d2);
  const double m10 = -l10 * i0 * i1;
  m << i0, 0.0, 0.0,  //
      m10, i1, 0.0,   //
      -(l20 * i0 + l21 * m10) * i2, -l21 * i1 * i2, i2;
  return true;
}

}  // namespace

std::size_t EliminationPattern::find(int row, int column) const {
  const auto begin = rows.begin() + column_start[index(column)];
  const auto end = rows.begin() + column_start[index(column) + 1];
  return static_cast<std::size_t>(std::lower_bound(begin, end, row) - rows.begin());
}

EliminationPattern elimination_pattern(int size, std::span<const std::pair<int, int>> pairs) {
  EliminationPattern pattern;
  pattern.place = fill_reducing_order(size, pairs);
  // Rows of A below the diagonal, column by column.
  std::vector<std::pair<int, int>> blocks;
  blocks.reserve(pairs.size());
  for (const auto& [a, b] : pairs) {
    const auto [low, high] = std::minmax(pattern.place[index(a)], pattern.place[index(b)]);
    if (low != high) blocks.emplace_back(low, high);
  }
  std::sort(blocks.begin(), blocks.end());
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());

  // The rows of column j of L: those of A, and those of its children in the elimination tree.
  pattern.column_start.assign(index(size) + 1, 0);
  pattern.rows.reserve(4 * blocks.size());
  std::vector<int> first_child(index(size), kNone);
  std::vector<int> next_sibling(index(size), kNone);
  std::vector<int> seen_by(index(size), kNone);
  std::size_t next_block = 0;
  for (int j = 0; j < size; ++j) {
    const std::size_t begin = pattern.rows.size();
    const auto add = [&](int row) {
      if (row == j || seen_by[index(row)] == j) return;
      seen_by[index(row)] = j;
      pattern.rows.push_back(row);
    };
    for (; next_block < blocks.size() && blocks[next_block].first == j; ++next_block) {
      add(blocks[next_block].second);
    }
    for (int child = first_child[index(j)]; child != kNone; child = next_sibling[index(child)]) {
      const int end = pattern.column_start[index(child) + 1];
      for (int p = pattern.column_start[index(child)]; p < end; ++p) add(pattern.rows[index(p)]);
    }
    std::sort(pattern.rows.begin() + static_cast<std::ptrdiff_t>(begin), pattern.rows.end());
    pattern.column_start[index(j) + 1] = static_cast<int>(pattern.rows.size());
    if (pattern.rows.size() > begin) {
      const std::size_t parent = index(pattern.rows[begin]);
      next_sibling[index(j)] = first_child[parent];
      first_child[parent] = j;
    }
  }
  return pattern;
}

template <typename Block>
ConnectionCholesky<Block>::ConnectionCholesky(const EliminationPattern& pattern)
    : pattern_(&pattern),
      diagonal_(pattern.size()),
      below_(pattern.rows.size()),
      next_(pattern.size()),
      position_(pattern.size()),
      slot_(pattern.size()) {}

template <typename Block>
void ConnectionCholesky<Block>::set_zero() {
  std::fill(diagonal_.begin(), diagonal_.end(), Block{});
  std::fill(below_.begin(), below_.end(), Block{});
}

template <typename Block>
bool ConnectionCholesky<Block>::factorise() {
  first_of_row_.assign(diagonal_.size(), kNone);
  for (std::size_t j = 0; j < diagonal_.size(); ++j) {
    subtract_pending(j);
    if (!finish_column(j)) return false;
  }
  return true;
}

template <typename Block>
void ConnectionCholesky<Block>::defer(int column, int position) {
  if (position == pattern_->column_start[index(column) + 1]) return;
  int& first = first_of_row_[index(pattern_->rows[index(position)])];
  position_[index(column)] = position;
  next_[index(column)] = first;
  first = column;
}

template <typename Block>
void ConnectionCholesky<Block>::subtract_pending(std::size_t column) {
  const std::vector<int>& rows = pattern_->rows;
  for (int p = pattern_->column_start[column]; p < pattern_->column_start[column + 1]; ++p) {
    slot_[index(rows[index(p)])] = p;
  }
  for (int k = first_of_row_[column]; k != kNone;) {
    const int next = next_[index(k)];
    const int position = position_[index(k)];
    const Block factor = below_[index(position)];
    subtract_product(diagonal_[column], factor, factor);
    const int end = pattern_->column_start[index(k) + 1];
    for (int p = position + 1; p < end; ++p) {
      subtract_product(below_[index(slot_[index(rows[index(p)])])], below_[index(p)], factor);
    }
    defer(k, position + 1);
    k = next;
  }
}

template <typename Block>
bool ConnectionCholesky<Block>::finish_column(std::size_t column) {
  if (!invert_factor(diagonal_[column])) return false;
  for (int p = pattern_->column_start[column]; p < pattern_->column_start[column + 1]; ++p) {
    below_[index(p)] = times_adjoint(below_[index(p)], diagonal_[column]);
  }
  defer(static_cast<int>(column), pattern_->column_start[column]);
  return true;
}

template <typename Block>
void ConnectionCholesky<Block>::solve_in_place(std::vector<Values>& b) const {
  const std::vector<int>& start = pattern_->column_start;
  for (std::size_t j = 0; j < diagonal_.size(); ++j) {
    Values value = Values::Zero();
    subtract_applied(value, diagonal_[j], b[j]);
    b[j] = -value;
    for (int p = start[j]; p < start[j + 1]; ++p) {
      subtract_applied(b[index(pattern_->rows[index(p)])], below_[index(p)], b[j]);
    }
  }
  for (std::size_t j = diagonal_.size(); j-- > 0;) {
    Values sum = b[j];
    for (int p = start[j]; p < start[j + 1]; ++p) {
      subtract_adjoint_applied(sum, below_[index(p)], b[index(pattern_->rows[index(p)])]);
    }
    Values value = Values::Zero();
    subtract_adjoint_applied(value, diagonal_[j], sum);
    b[j] = -value;
  }
}

template class ConnectionCholesky<ComplexBlock<1>>;
template class ConnectionCholesky<ComplexBlock<2>>;
template class ConnectionCholesky<RealBlock<3>>;

}  // namespace loopstone
