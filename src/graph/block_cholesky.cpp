#include "graph/block_cholesky.hpp"

#include <algorithm>
#include <cstdint>

#include "graph/front_assembly.hpp"

namespace loopstone {

BlockCholesky::BlockCholesky(const BlockMatrix& pattern) {
  const int size = static_cast<int>(pattern.diagonal.size());
  std::vector<std::pair<int, int>> pairs;
  pairs.reserve(pattern.rows.size());
  for (int j = 0; j < size; ++j) {
    const auto column = static_cast<std::size_t>(j);
    for (int p = pattern.column_start[column]; p < pattern.column_start[column + 1]; ++p) {
      pairs.emplace_back(j, pattern.rows[static_cast<std::size_t>(p)]);
    }
  }
  tree_ = front_tree(size, pairs);
  lay_out_fronts();
  lay_out_entries(pattern);
}

void BlockCholesky::lay_out_fronts() {
  std::size_t panel_end = 0;
  std::array<std::size_t, 2> top{0, 0};
  std::array<std::size_t, 2> highest{0, 0};
  std::size_t longest = 0;
  for (const Front& front : tree_.fronts) {
    const auto pivots = static_cast<std::size_t>(front.pivots);
    const auto below = static_cast<std::size_t>(front.below());
    fill_ += pivots * (pivots - 1) / 2 + pivots * below;
    panel_start_.push_back(panel_end);
    panel_end += 3 * pivots * padded_rows(3 * (pivots + below));
    // The fronts on a stack of one parity are finished but not yet taken up; when this one is, its
    // children, on the other stack, are gone.
    const auto parity = static_cast<std::size_t>(front.depth % 2);
    update_start_.push_back(top[parity]);
    top[parity] += 3 * below * padded_rows(3 * below);
    highest[parity] = std::max(highest[parity], top[parity]);
    if (!front.children.empty()) {
      top[1 - parity] = update_start_[static_cast<std::size_t>(front.children.front())];
    }
    longest = std::max(longest, padded_rows(3 * below));
  }
  panels_ = std::make_unique_for_overwrite<double[]>(panel_end + kFrontSlack);
  std::fill_n(panels_.get() + panel_end, kFrontSlack, 0.0);
  for (std::size_t parity = 0; parity < 2; ++parity) {
    stacks_[parity] = std::make_unique_for_overwrite<double[]>(highest[parity] + kFrontSlack);
  }
  inverse_diagonal_.assign(3 * tree_.place.size(), 0.0);
  x_.assign(3 * tree_.place.size(), 0.0);
  below_.assign(longest, 0.0);
}

void BlockCholesky::lay_out_entries(const BlockMatrix& pattern) {
  const auto place = [this](int i) { return tree_.place[static_cast<std::size_t>(i)]; };
  const int size = static_cast<int>(pattern.diagonal.size());
  const auto for_each_block = [&](auto&& visit) {
    for (int j = 0; j < size; ++j) {
      visit(-1 - j, place(j), place(j));
      const auto column = static_cast<std::size_t>(j);
      for (int p = pattern.column_start[column]; p < pattern.column_start[column + 1]; ++p) {
        visit(p, place(pattern.rows[static_cast<std::size_t>(p)]), place(j));
      }
    }
  };
  const auto front_at = [this](int a, int b) {
    return static_cast<std::size_t>(tree_.front_of[static_cast<std::size_t>(std::min(a, b))]);
  };
  entry_start_.assign(tree_.fronts.size() + 1, 0);
  for_each_block([&](int, int row, int column) { ++entry_start_[front_at(row, column) + 1]; });
  for (std::size_t i = 1; i < entry_start_.size(); ++i) entry_start_[i] += entry_start_[i - 1];
  entries_.resize(entry_start_.back());
  std::vector<std::size_t> next(entry_start_.begin(), entry_start_.end() - 1);
  for_each_block([&](int source, int row, int column) {
    const std::size_t f = front_at(row, column);
    const bool transposed = row < column;
    const std::size_t offset =
        panel_offset(tree_.fronts[f], std::max(row, column), std::min(row, column));
    entries_[next[f]++] = {source, offset, transposed};
  });
}

DenseFront BlockCholesky::dense_front(std::size_t front) {
  const Front& f = tree_.fronts[front];
  return {panels_.get() + panel_start_[front],
          stacks_[static_cast<std::size_t>(f.depth % 2)].get() + update_start_[front],
          inverse_diagonal_.data() + 3 * static_cast<std::size_t>(f.first_pivot),
          3 * static_cast<std::size_t>(f.size()), 3 * static_cast<std::size_t>(f.pivots)};
}

void BlockCholesky::assemble(std::size_t front, const BlockMatrix& a, double damping,
                             const DenseFront& dense) {
  clear(dense);
  const std::size_t stride = padded_rows(dense.rows);
  for (std::size_t e = entry_start_[front]; e < entry_start_[front + 1]; ++e) {
    const Entry& entry = entries_[e];
    double* target = dense.panel + entry.offset;
    if (entry.source < 0) {
      add_block(a.diagonal[static_cast<std::size_t>(-1 - entry.source)], target, stride);
      for (std::size_t k = 0; k < 3; ++k) target[k * stride + k] *= 1.0 + damping;
    } else if (entry.transposed) {
      add_block(a.below[static_cast<std::size_t>(entry.source)].transpose(), target, stride);
    } else {
      add_block(a.below[static_cast<std::size_t>(entry.source)], target, stride);
    }
  }
  for (const int child : tree_.fronts[front].children) {
    const auto c = static_cast<std::size_t>(child);
    add_update(tree_.fronts[c].runs, dense_front(c), dense);
  }
}

bool BlockCholesky::factorise(const BlockMatrix& a, double damping) {
  for (std::size_t f = 0; f < tree_.fronts.size(); ++f) {
    const DenseFront dense = dense_front(f);
    assemble(f, a, damping, dense);
    if (!factorise_front(dense)) return false;
  }
  return true;
}

void BlockCholesky::put(std::span<const Eigen::Vector3d> b) {
  for (std::size_t i = 0; i < b.size(); ++i)
    Eigen::Map<Eigen::Vector3d>(x_at(tree_.place[i])) = b[i];
}

void BlockCholesky::take(std::span<Eigen::Vector3d> b) {
  for (std::size_t i = 0; i < b.size(); ++i)
    b[i] = Eigen::Map<const Eigen::Vector3d>(x_at(tree_.place[i]));
}

void BlockCholesky::substitute_back() {
  for (std::size_t f = tree_.fronts.size(); f-- > 0;) {
    const Front& front = tree_.fronts[f];
    double* part = below_.data();
    for (const int row : front.rows) {
      const double* x = x_at(row);
      for (int k = 0; k < 3; ++k) *part++ = x[k];
    }
    solve_front_backward(dense_front(f), x_at(front.first_pivot), below_.data());
  }
}

void BlockCholesky::solve_in_place(std::span<Eigen::Vector3d> b) {
  put(b);
  for (std::size_t f = 0; f < tree_.fronts.size(); ++f) {
    const Front& front = tree_.fronts[f];
    solve_front_forward(dense_front(f), x_at(front.first_pivot), below_.data());
    const double* part = below_.data();
    for (const int row : front.rows) {
      double* x = x_at(row);
      for (int k = 0; k < 3; ++k) x[k] -= *part++;
    }
  }
  substitute_back();
  take(b);
}

void BlockCholesky::colour_in_place(std::span<Eigen::Vector3d> z) {
  put(z);
  substitute_back();
  take(z);
}

std::vector<Eigen::Vector3d> BlockCholesky::solve(std::vector<Eigen::Vector3d> b) {
  solve_in_place(b);
  return b;
}

Eigen::Matrix3d BlockCholesky::through_inverse(std::span<const RowsAt> j) {
  // Parents come after their children, so two paths are merged by sorting.
  path_.clear();
  for (const RowsAt& rows : j) {
    const int place = tree_.place[static_cast<std::size_t>(rows.block)];
    for (int f = tree_.front_of[static_cast<std::size_t>(place)]; f >= 0;
         f = tree_.fronts[static_cast<std::size_t>(f)].parent) {
      path_.push_back(static_cast<std::size_t>(f));
    }
  }
  std::sort(path_.begin(), path_.end());
  path_.erase(std::unique(path_.begin(), path_.end()), path_.end());

  // J A^-1 J^T = W^T W with W = L^-1 J^T.
  std::size_t height = 0;
  for (const std::size_t f : path_) height += 3 * static_cast<std::size_t>(tree_.fronts[f].pivots);
  Eigen::Matrix<double, Eigen::Dynamic, 3> w(height, 3);
  for (int k = 0; k < 3; ++k) {
    for (const std::size_t f : path_) {
      const Front& front = tree_.fronts[f];
      std::fill_n(x_at(front.first_pivot), 3 * front.pivots, 0.0);
    }
    for (const RowsAt& rows : j) {
      Eigen::Map<Eigen::Vector3d>(x_at(tree_.place[static_cast<std::size_t>(rows.block)])) +=
          rows.rows.row(k).transpose();
    }
    double* target = w.col(k).data();
    for (const std::size_t f : path_) {
      const Front& front = tree_.fronts[f];
      double* x = x_at(front.first_pivot);
      solve_front_forward(dense_front(f), x, below_.data());
      target = std::copy_n(x, 3 * front.pivots, target);
      const double* part = below_.data();
      for (const int row : front.rows) {
        double* later = x_at(row);
        for (int i = 0; i < 3; ++i) later[i] -= *part++;
      }
    }
  }
  return w.transpose().lazyProduct(w);  // no blocks by the size of a cache
}

}  // namespace loopstone
