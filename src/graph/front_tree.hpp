#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace loopstone {

/// Consecutive rows of a front and the consecutive rows of its parent where they go.
struct RowRun {
  int here = 0;
  int in_parent = 0;
  int length = 0;
};

/// Columns of L with (nearly) the same rows, eliminated together as one dense matrix: a supernode.
/// Its pivots are followed by the rows below, all in blocks.
struct Front {
  int first_pivot = 0;
  int pivots = 0;
  int parent = -1;
  int depth = 0;          ///< steps to the root
  std::vector<int> rows;  ///< places below the pivots that L reaches, ascending
  std::vector<RowRun>
      /// where `rows` stand among the parent's pivots and rows, counted from its first pivot
      runs;
  std::vector<int> children;

  [[nodiscard]] int below() const { return static_cast<int>(rows.size()); }
  [[nodiscard]] int size() const { return pivots + below(); }
};

/// The supernodes of a pattern, children before parents.
struct FrontTree {
  std::vector<int> place;  ///< of each block of the pattern: elimination goes front by front
  std::vector<Front> fronts;
  std::vector<int> front_of;  ///< which front has the pivot at a place
};

/// Where the rows of a front stand among the pivots and rows of its parent.
[[nodiscard]] std::vector<RowRun> runs_in_parent(const Front& front, const Front& parent);

/// The elimination tree of a symmetric pattern (Liu 1990) cut into supernodes; small ones are
/// merged with their parents where that adds few zeros (Ashcraft and Grimes 1989). The pairs (any
/// order, may repeat) are the blocks off the diagonal; blocks are eliminated in their order, up to
/// a reordering that leaves L's pattern as it is.
[[nodiscard]] FrontTree front_tree(int size, std::span<const std::pair<int, int>> pairs);

}  // namespace loopstone
