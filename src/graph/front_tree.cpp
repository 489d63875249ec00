#include "graph/front_tree.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>

namespace loopstone {

namespace {

constexpr int kNone = -1;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// The lower rows of each node: those with which it is paired and that are eliminated before it.
struct LowerRows {
  std::vector<int> start;
  std::vector<int> columns;
};

LowerRows lower_rows(int size, std::span<const std::pair<int, int>> pairs) {
  LowerRows result;
  result.start.assign(at(size) + 1, 0);
  for (const auto& [a, b] : pairs) {
    if (a != b) ++result.start[at(std::max(a, b)) + 1];
  }
  std::partial_sum(result.start.begin(), result.start.end(), result.start.begin());
  result.columns.resize(at(result.start.back()));
  std::vector<int> next(result.start.begin(), result.start.end() - 1);
  for (const auto& [a, b] : pairs) {
    if (a != b) result.columns[at(next[at(std::max(a, b))]++)] = std::min(a, b);
  }
  return result;
}

std::vector<int> elimination_tree(int size, const LowerRows& lower) {
  std::vector<int> parent(at(size), kNone);
  std::vector<int> ancestor(at(size), kNone);
  for (int i = 0; i < size; ++i) {
    for (int p = lower.start[at(i)]; p < lower.start[at(i) + 1]; ++p) {
      int j = lower.columns[at(p)];
      while (j != kNone && j != i) {
        const int up = ancestor[at(j)];
        ancestor[at(j)] = i;  // path compression
        if (up == kNone) parent[at(j)] = i;
        j = up;
      }
    }
  }
  return parent;
}

/// Blocks in each column of L below the diagonal: row i of L holds the paths from its entries up to
/// i.
std::vector<int> column_counts(int size, const LowerRows& lower, const std::vector<int>& parent) {
  std::vector<int> count(at(size), 0);
  std::vector<int> seen_by(at(size), kNone);
  for (int i = 0; i < size; ++i) {
    seen_by[at(i)] = i;
    for (int p = lower.start[at(i)]; p < lower.start[at(i) + 1]; ++p) {
      for (int j = lower.columns[at(p)]; seen_by[at(j)] != i; j = parent[at(j)]) {
        seen_by[at(j)] = i;
        ++count[at(j)];
      }
    }
  }
  return count;
}

/// Columns that will be one front, linked through their topmost one.
struct Group {
  int pivots = 1;
  int below = 0;
  std::int64_t zeros = 0;  ///< blocks that hold nothing but are computed with
};

/// Whether a child is worth merging: few zeros, measured against what the merged front holds.
bool worth_merging(const Group& child, const Group& parent, Group& merged) {
  merged.pivots = child.pivots + parent.pivots;
  merged.below = parent.below;
  const std::int64_t extra =
      static_cast<std::int64_t>(child.pivots) * (parent.pivots + parent.below - child.below);
  merged.zeros = child.zeros + parent.zeros + extra;
  if (extra == 0) return true;
  const std::int64_t blocks = static_cast<std::int64_t>(merged.pivots) * (merged.pivots + 1) / 2 +
                              static_cast<std::int64_t>(merged.pivots) * merged.below;
  const double share = static_cast<double>(merged.zeros) / static_cast<double>(blocks);
  if (merged.pivots <= 4) return share < 0.3;
  if (merged.pivots <= 12) return share < 0.1;
  return share < 0.02;
}

/// The column that stands for the group of each column: its topmost one.
std::vector<int> merged_columns(const std::vector<int>& parent, const std::vector<int>& count,
                                std::vector<Group>& groups) {
  const std::size_t size = parent.size();
  std::vector<int> top(size);
  std::iota(top.begin(), top.end(), 0);
  groups.resize(size);
  for (std::size_t j = 0; j < size; ++j) groups[j].below = count[j];
  // Children come before parents, so a child is complete when it is offered to its parent; the one
  // with most rows first would need a sort, and in ascending order the deepest comes last, which
  // does as well.
  for (std::size_t j = 0; j < size; ++j) {
    const int p = parent[j];
    if (p == kNone) continue;
    Group merged;
    if (!worth_merging(groups[j], groups[at(p)], merged)) continue;
    groups[at(p)] = merged;
    top[j] = p;
  }
  for (std::size_t j = size; j-- > 0;) top[j] = top[at(top[j])];
  return top;
}

/// Numbers fronts and pivots in postorder.
void number_fronts(const std::vector<int>& parent, const std::vector<int>& top, FrontTree& tree) {
  const std::size_t size = parent.size();
  std::vector<std::vector<int>> members(size);
  std::vector<std::vector<int>> children(size);
  std::vector<int> roots;
  for (std::size_t j = 0; j < size; ++j) {
    members[at(top[j])].push_back(static_cast<int>(j));
    if (top[j] != static_cast<int>(j)) continue;
    if (parent[j] == kNone) {
      roots.push_back(static_cast<int>(j));
    } else {
      children[at(top[at(parent[j])])].push_back(static_cast<int>(j));
    }
  }
  tree.place.assign(size, kNone);
  tree.front_of.resize(size);
  int next_place = 0;
  std::vector<std::pair<int, std::size_t>> stack;  // group, next child
  std::vector<int> number(size, kNone);
  for (const int root : roots) {
    stack.emplace_back(root, 0);
    while (!stack.empty()) {
      auto& [group, next] = stack.back();
      if (next < children[at(group)].size()) {
        const int child = children[at(group)][next++];
        stack.emplace_back(child, 0);
        continue;
      }
      Front front;
      front.first_pivot = next_place;
      front.pivots = static_cast<int>(members[at(group)].size());
      number[at(group)] = static_cast<int>(tree.fronts.size());
      for (const int member : members[at(group)]) {
        tree.front_of[at(next_place)] = number[at(group)];
        tree.place[at(member)] = next_place++;
      }
      for (const int child : children[at(group)]) {
        front.children.push_back(number[at(child)]);
        tree.fronts[at(number[at(child)])].parent = number[at(group)];
      }
      tree.fronts.push_back(std::move(front));
      stack.pop_back();
    }
  }
  for (std::size_t f = tree.fronts.size(); f-- > 0;) {
    Front& front = tree.fronts[f];
    front.depth = front.parent == kNone ? 0 : tree.fronts[at(front.parent)].depth + 1;
  }
}

/// The rows of a front: those of the pattern, and those of its children.
void find_rows(std::span<const std::pair<int, int>> pairs, FrontTree& tree) {
  const std::size_t size = tree.place.size();
  std::vector<int> start(size + 1, 0);
  const auto place = [&tree](int node) { return tree.place[at(node)]; };
  for (const auto& [a, b] : pairs) {
    if (a != b) ++start[at(std::min(place(a), place(b))) + 1];
  }
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<int> rows(at(start.back()));
  std::vector<int> next(start.begin(), start.end() - 1);
  for (const auto& [a, b] : pairs) {
    if (a == b) continue;
    const int low = std::min(place(a), place(b));
    rows[at(next[at(low)]++)] = std::max(place(a), place(b));
  }
  std::vector<int> seen_by(size, kNone);
  for (std::size_t f = 0; f < tree.fronts.size(); ++f) {
    Front& front = tree.fronts[f];
    const int end = front.first_pivot + front.pivots;
    const auto add = [&](int row) {
      if (row < end || seen_by[at(row)] == static_cast<int>(f)) return;
      seen_by[at(row)] = static_cast<int>(f);
      front.rows.push_back(row);
    };
    for (int p = start[at(front.first_pivot)]; p < start[at(end)]; ++p) add(rows[at(p)]);
    for (const int child : front.children) {
      for (const int row : tree.fronts[at(child)].rows) add(row);
    }
    std::sort(front.rows.begin(), front.rows.end());
  }
}

}  // namespace

std::vector<RowRun> runs_in_parent(const Front& front, const Front& parent) {
  std::vector<RowRun> runs;
  std::size_t below = 0;
  for (int i = 0; i < front.below(); ++i) {
    const int row = front.rows[at(i)];
    int position = row - parent.first_pivot;
    if (position >= parent.pivots) {
      while (parent.rows[below] != row) ++below;
      position = parent.pivots + static_cast<int>(below);
    }
    // A run does not cross from the parent's pivots to the rows below them.
    const bool starts_below = position == parent.pivots;
    if (!runs.empty() && runs.back().in_parent + runs.back().length == position && !starts_below) {
      ++runs.back().length;
    } else {
      runs.push_back({i, position, 1});
    }
  }
  return runs;
}

FrontTree front_tree(int size, std::span<const std::pair<int, int>> pairs) {
  const LowerRows lower = lower_rows(size, pairs);
  const std::vector<int> parent = elimination_tree(size, lower);
  const std::vector<int> count = column_counts(size, lower, parent);
  std::vector<Group> groups;
  const std::vector<int> top = merged_columns(parent, count, groups);
  FrontTree tree;
  number_fronts(parent, top, tree);
  find_rows(pairs, tree);
  for (Front& front : tree.fronts) {
    if (front.parent != kNone) front.runs = runs_in_parent(front, tree.fronts[at(front.parent)]);
  }
  return tree;
}

}  // namespace loopstone
