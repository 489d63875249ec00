#include <algorithm>
#include <cstddef>
#include <utility>

#include "graph/clique_tree.hpp"
#include "graph/front_assembly.hpp"

// The elimination of a part of the tree, front by front.
namespace loopstone {

namespace {

constexpr int kNone = -1;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

using MapVector = Eigen::Map<Eigen::Vector3d>;

}  // namespace

std::vector<std::size_t> CliqueTree::positions_in(const Front& front,
                                                  const std::vector<int>& variables) const {
  std::vector<std::size_t> positions;
  positions.reserve(variables.size());
  for (const int variable : variables) {
    const int place = place_of(variable);
    const int pivot = place - front.first_pivot;
    if (pivot < front.pivots) {
      positions.push_back(3 * at(pivot));
    } else {
      const auto found = std::lower_bound(front.rows.begin(), front.rows.end(), place);
      positions.push_back(
          3 * (at(front.pivots) + static_cast<std::size_t>(found - front.rows.begin())));
    }
  }
  return positions;
}

void CliqueTree::add_orphan(int orphan, int clique, const Front& front) {
  // The rows of an orphan may have changed their order: block by block, transposed where that is
  // so.
  Clique& child = cliques_[at(orphan)];
  child.parent = clique;
  cliques_[at(clique)].children.push_back(orphan);
  const DenseFront from = child.dense();
  const DenseFront to = cliques_[at(clique)].dense();
  const std::size_t child_stride = padded_rows(child.below_count());
  const std::size_t panel_stride = padded_rows(to.rows);
  const std::size_t update_stride = padded_rows(to.rows - to.pivots);
  const std::vector<std::size_t> position = positions_in(front, child.rows);
  const auto target = [&](std::size_t row, std::size_t column) {
    return column < to.pivots
               ? to.panel + column * panel_stride + row
               : to.update + (column - to.pivots) * update_stride + (row - to.pivots);
  };
  double* forward = cliques_[at(clique)].forward();
  double* left_over = cliques_[at(clique)].left_over();
  const double* rest = child.left_over();
  for (std::size_t j = 0; j < position.size(); ++j) {
    const std::size_t column = position[j];
    double* b = column < to.pivots ? forward + column : left_over + (column - to.pivots);
    for (std::size_t k = 0; k < 3; ++k) b[k] += rest[3 * j + k];
    for (std::size_t i = j; i < position.size(); ++i) {
      const double* block = from.update + 3 * j * child_stride + 3 * i;
      const std::size_t row = position[i];
      if (row >= column) {
        double* sum = target(row, column);
        const std::size_t stride = column < to.pivots ? panel_stride : update_stride;
        for (std::size_t c = 0; c < 3; ++c) {
          for (std::size_t r = 0; r < 3; ++r) sum[c * stride + r] += block[c * child_stride + r];
        }
      } else {
        double* sum = target(column, row);
        const std::size_t stride = row < to.pivots ? panel_stride : update_stride;
        for (std::size_t c = 0; c < 3; ++c) {
          for (std::size_t r = 0; r < 3; ++r) sum[r * stride + c] += block[c * child_stride + r];
        }
      }
    }
  }
}

CliqueTree::Layout CliqueTree::lay_out(const Part& part, std::span<const LinearFactor> factors,
                                       const std::vector<std::vector<int>>& factors_of) {
  const auto size = static_cast<int>(part.variables.size());
  std::vector<std::pair<int, int>> pairs;
  for (const int variable : part.variables) {
    for (const int f : factors_of[at(variable)]) {
      const LinearFactor& factor = factors[at(f)];
      if (factor.second == kNone || factor.first != variable) continue;
      if (local_[at(factor.second)] == kNone) continue;
      pairs.emplace_back(place_of(variable), place_of(factor.second));
    }
  }
  // An orphan's rows need only be joined to the first of them: its elimination joins the rest.
  std::vector<int> first_of_orphan;
  for (const int orphan : part.orphans) {
    const std::vector<int>& rows = cliques_[at(orphan)].rows;
    int first = size;
    for (const int row : rows) first = std::min(first, place_of(row));
    first_of_orphan.push_back(first);
    for (const int row : rows) pairs.emplace_back(first, place_of(row));
  }

  Layout layout;
  layout.tree = front_tree(size, pairs);
  for (int& p : order_) p = layout.tree.place[at(p)];
  layout.variable_at.resize(at(size));
  for (int i = 0; i < size; ++i) layout.variable_at[at(order_[at(i)])] = part.variables[at(i)];
  layout.orphans_of.resize(layout.tree.fronts.size());
  for (std::size_t o = 0; o < part.orphans.size(); ++o) {
    const int first = layout.tree.place[at(first_of_orphan[o])];
    // Within a front pivots may have been renumbered, so the first row need not be the same, but
    // its front is.
    layout.orphans_of[at(layout.tree.front_of[at(first)])].push_back(part.orphans[o]);
  }
  return layout;
}

int CliqueTree::begin_clique(const Front& front, const std::vector<int>& variable_at) {
  const int c = new_clique();
  new_cliques_.push_back(c);
  Clique& clique = cliques_[at(c)];
  clique.alive = true;
  for (int p = 0; p < front.pivots; ++p) {
    const int variable = variable_at[at(front.first_pivot + p)];
    clique.pivots.push_back(variable);
    clique_of_[at(variable)] = c;
  }
  for (const int row : front.rows) clique.rows.push_back(variable_at[at(row)]);
  clique.values = spare_.zeros(clique.value_count());
  return c;
}

void CliqueTree::add_factors(int c, const Front& front, std::span<const LinearFactor> factors,
                             const std::vector<std::vector<int>>& factors_of) {
  Clique& clique = cliques_[at(c)];
  const DenseFront dense = clique.dense();
  const std::size_t stride = padded_rows(dense.rows);
  double* forward = clique.forward();
  for (const int variable : clique.pivots) {
    const int here = place_of(variable);
    for (const int i : factors_of[at(variable)]) {
      const LinearFactor& factor = factors[at(i)];
      const bool is_first = factor.first == variable;
      const auto& diagonal = is_first ? factor.first_first : factor.second_second;
      add_block(diagonal, dense.panel + panel_offset(front, here, here), stride);
      MapVector(forward + 3 * (here - front.first_pivot)) -=
          is_first ? factor.gradient_first : factor.gradient_second;
      const int other = is_first ? factor.second : factor.first;
      if (other == kNone || local_[at(other)] == kNone) continue;
      const int there = place_of(other);
      if (there < here) continue;  // there already
      double* target = dense.panel + panel_offset(front, there, here);
      // The block (row other, column variable).
      if (is_first) {
        add_block(factor.first_second.transpose(), target, stride);
      } else {
        add_block(factor.first_second, target, stride);
      }
    }
  }
}

void CliqueTree::add_child(int child, const Front& child_front, int c) {
  Clique& below = cliques_[at(child)];
  Clique& clique = cliques_[at(c)];
  below.parent = c;
  clique.children.push_back(child);
  add_update(child_front.runs, below.dense(), clique.dense());
  const double* rest = below.left_over();
  double* forward = clique.forward();
  double* left_over = clique.left_over();
  const auto pivots = static_cast<int>(clique.pivot_count());
  for (const RowRun& run : child_front.runs) {
    for (int i = 0; i < 3 * run.length; ++i) {
      const int position = 3 * run.in_parent + i;
      double& b = position < pivots ? forward[position] : left_over[position - pivots];
      b += rest[3 * run.here + i];
    }
  }
}

bool CliqueTree::eliminate_pivots(int c) {
  Clique& clique = cliques_[at(c)];
  const DenseFront dense = clique.dense();
  if (!factorise_front(dense)) return false;
  below_.resize(std::max(below_.size(), padded_rows(clique.below_count())));
  solve_front_forward(dense, clique.forward(), below_.data());
  double* left_over = clique.left_over();
  for (std::size_t i = 0; i < clique.below_count(); ++i) left_over[i] -= below_[i];
  return true;
}

bool CliqueTree::eliminate(const Part& part, std::span<const LinearFactor> factors,
                           const std::vector<std::vector<int>>& factors_of) {
  const Layout layout = lay_out(part, factors, factors_of);
  new_cliques_.clear();
  // Children come before their parents.
  for (std::size_t f = 0; f < layout.tree.fronts.size(); ++f) {
    const Front& front = layout.tree.fronts[f];
    const int c = begin_clique(front, layout.variable_at);
    add_factors(c, front, factors, factors_of);
    for (const int child : front.children) {
      add_child(new_cliques_[at(child)], layout.tree.fronts[at(child)], c);
    }
    for (const int orphan : layout.orphans_of[f]) add_orphan(orphan, c, front);
    if (!eliminate_pivots(c)) return false;
  }
  return true;
}

}  // namespace loopstone
