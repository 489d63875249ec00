#include "graph/block_cholesky.hpp"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

namespace loopstone {

namespace {

constexpr int kNone = -1;

/// The inverse of the Cholesky factor of a 3x3 matrix (lower triangle read); false when it is not positive definite.
bool inverse_cholesky(const Eigen::Matrix3d& a, Eigen::Matrix3d& inverse) {
  const double d0 = a(0, 0);
  if (!(d0 > 0.0)) return false;
  const double i0 = 1.0 / std::sqrt(d0);
  const double l10 = a(1, 0) * i0;
  const double l20 = a(2, 0) * i0;
  const double d1 = a(1, 1) - l10 * l10;
  if (!(d1 > 0.0)) return false;
  const double i1 = 1.0 / std::sqrt(d1);
  const double l21 = (a(2, 1) - l20 * l10) * i1;
  const double d2 = a(2, 2) - l20 * l20 - l21 * l21;
  if (!(d2 > 0.0) || !std::isfinite(d2)) return false;
  const double i2 = 1.0 / std::sqrt(d2);
  const double m10 = -l10 * i0 * i1;
  const double m21 = -l21 * i1 * i2;
  const double m20 = -(l20 * i0 + l21 * m10) * i2;
  inverse << i0, 0.0, 0.0,  //
      m10, i1, 0.0,         //
      m20, m21, i2;
  return true;
}

}  // namespace

BlockMatrix block_matrix(int size, std::vector<std::pair<int, int>> pairs) {
  for (auto& [column, row] : pairs) {
    if (column > row) std::swap(column, row);
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  BlockMatrix result;
  result.column_start.assign(static_cast<std::size_t>(size) + 1, 0);
  result.rows.reserve(pairs.size());
  for (const auto& [column, row] : pairs) {
    if (column == row) continue;
    ++result.column_start[static_cast<std::size_t>(column) + 1];
    result.rows.push_back(row);
  }
  for (std::size_t i = 1; i < result.column_start.size(); ++i) {
    result.column_start[i] += result.column_start[i - 1];
  }
  result.diagonal.assign(static_cast<std::size_t>(size), Eigen::Matrix3d::Zero());
  result.below.assign(result.rows.size(), Eigen::Matrix3d::Zero());
  return result;
}

std::vector<int> fill_reducing_order(int size, std::span<const std::pair<int, int>> pairs) {
  using Pattern = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
  std::vector<Eigen::Triplet<double, int>> entries;
  entries.reserve(2 * pairs.size() + static_cast<std::size_t>(size));
  for (int i = 0; i < size; ++i) entries.emplace_back(i, i, 1.0);
  for (const auto& [a, b] : pairs) {
    entries.emplace_back(a, b, 1.0);
    entries.emplace_back(b, a, 1.0);
  }
  Pattern pattern(size, size);
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::AMDOrdering<int>::PermutationType order(size);
  Eigen::AMDOrdering<int>{}(pattern, order);
  // Eigen gives the inverse permutation: indices()[place] = i.
  std::vector<int> place(static_cast<std::size_t>(size));
  for (int i = 0; i < size; ++i) place[static_cast<std::size_t>(order.indices()[i])] = i;
  return place;
}

BlockCholesky::BlockCholesky(const BlockMatrix& pattern) {
  const std::size_t size = pattern.diagonal.size();
  // The rows of column j of L: those of A, and those of its children in the elimination tree.
  column_start_.assign(size + 1, 0);
  rows_.reserve(4 * pattern.rows.size());
  std::vector<int> first_child(size, kNone);
  std::vector<int> next_sibling(size, kNone);
  std::vector<int> seen_by(size, kNone);
  for (std::size_t j = 0; j < size; ++j) {
    const int column = static_cast<int>(j);
    const auto add = [&](int row) {
      if (row == column || seen_by[static_cast<std::size_t>(row)] == column) return;
      seen_by[static_cast<std::size_t>(row)] = column;
      rows_.push_back(row);
    };
    const std::size_t begin = rows_.size();
    for (int p = pattern.column_start[j]; p < pattern.column_start[j + 1]; ++p) {
      add(pattern.rows[static_cast<std::size_t>(p)]);
    }
    for (int child = first_child[j]; child != kNone;
         child = next_sibling[static_cast<std::size_t>(child)]) {
      const auto c = static_cast<std::size_t>(child);
      for (int p = column_start_[c]; p < column_start_[c + 1]; ++p) {
        add(rows_[static_cast<std::size_t>(p)]);
      }
    }
    std::sort(rows_.begin() + static_cast<std::ptrdiff_t>(begin), rows_.end());
    column_start_[j + 1] = static_cast<int>(rows_.size());
    if (rows_.size() > begin) {
      const auto parent = static_cast<std::size_t>(rows_[begin]);
      next_sibling[j] = first_child[parent];
      first_child[parent] = column;
    }
  }
  below_.resize(rows_.size());
  inverse_diagonal_.resize(size);
  work_.resize(size);
  pending_.next.resize(size);
  pending_.position.resize(size);
}

bool BlockCholesky::factorise(const BlockMatrix& a, double damping) {
  const std::size_t size = a.diagonal.size();
  pending_.first_of_row.assign(size, kNone);
  for (std::size_t j = 0; j < size; ++j) {
    work_[j] = a.diagonal[j];
    work_[j].diagonal() *= 1.0 + damping;
    for (int p = column_start_[j]; p < column_start_[j + 1]; ++p) {
      work_[static_cast<std::size_t>(rows_[static_cast<std::size_t>(p)])].setZero();
    }
    for (int p = a.column_start[j]; p < a.column_start[j + 1]; ++p) {
      const auto i = static_cast<std::size_t>(p);
      work_[static_cast<std::size_t>(a.rows[i])] = a.below[i];
    }
    subtract_pending(static_cast<int>(j));
    if (!finish_column(static_cast<int>(j))) return false;
  }
  return true;
}

void BlockCholesky::defer(int column, int position) {
  const auto c = static_cast<std::size_t>(column);
  if (position == column_start_[c + 1]) return;
  int& first =
      pending_.first_of_row[static_cast<std::size_t>(rows_[static_cast<std::size_t>(position)])];
  pending_.position[c] = position;
  pending_.next[c] = first;
  first = column;
}

void BlockCholesky::subtract_pending(int column) {
  Eigen::Matrix3d& diagonal = work_[static_cast<std::size_t>(column)];
  for (int k = pending_.first_of_row[static_cast<std::size_t>(column)]; k != kNone;) {
    const auto source = static_cast<std::size_t>(k);
    const int next = pending_.next[source];
    const int position = pending_.position[source];
    const Eigen::Matrix3d factor = below_[static_cast<std::size_t>(position)].transpose();
    diagonal.noalias() -= factor.transpose() * factor;
    for (int p = position + 1; p < column_start_[source + 1]; ++p) {
      const auto i = static_cast<std::size_t>(p);
      work_[static_cast<std::size_t>(rows_[i])].noalias() -= below_[i] * factor;
    }
    defer(k, position + 1);
    k = next;
  }
}

bool BlockCholesky::finish_column(int column) {
  const auto j = static_cast<std::size_t>(column);
  if (!inverse_cholesky(work_[j], inverse_diagonal_[j])) return false;
  const Eigen::Matrix3d factor = inverse_diagonal_[j].transpose();
  for (int p = column_start_[j]; p < column_start_[j + 1]; ++p) {
    const auto i = static_cast<std::size_t>(p);
    below_[i].noalias() = work_[static_cast<std::size_t>(rows_[i])] * factor;
  }
  defer(column, column_start_[j]);
  return true;
}

std::vector<Eigen::Vector3d> BlockCholesky::solve(std::vector<Eigen::Vector3d> b) const {
  const std::size_t size = inverse_diagonal_.size();
  for (std::size_t j = 0; j < size; ++j) {
    b[j] = inverse_diagonal_[j] * b[j];
    for (int p = column_start_[j]; p < column_start_[j + 1]; ++p) {
      const auto i = static_cast<std::size_t>(p);
      b[static_cast<std::size_t>(rows_[i])] -= below_[i] * b[j];
    }
  }
  for (std::size_t j = size; j-- > 0;) {
    Eigen::Vector3d sum = b[j];
    for (int p = column_start_[j]; p < column_start_[j + 1]; ++p) {
      const auto i = static_cast<std::size_t>(p);
      sum -= below_[i].transpose() * b[static_cast<std::size_t>(rows_[i])];
    }
    b[j] = inverse_diagonal_[j].transpose() * sum;
  }
  return b;
}

}  // namespace loopstone
