#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace loopstone {

/// A graph of some hundred nodes as rows of bits: what elimination joins costs next to nothing to
/// find there.
class SmallGraph {
 public:
  explicit SmallGraph(int size);

  void join(int a, int b);
  /// Each node with each other.
  void join_all(std::span<const int> nodes);

  /// The place of each node when the one is always eliminated next whose neighbours it will join
  /// with the fewest new pairs (of equal ones the lowest). Counted as new are all pairs but those
  /// of the largest set that is known to be joined.
  /// Source: Rothberg and Eisenstat 1998, "Node selection strategies for bottom-up sparse matrix
  /// ordering", section 3.
  [[nodiscard]] std::vector<int> minimum_fill_order() &&;

 private:
  [[nodiscard]] std::uint64_t* row(int node) {
    return bits_.data() + static_cast<std::size_t>(node) * words_;
  }
  void eliminate(int node);
  void rate(int node);

  std::size_t words_ = 0;  ///< in a row
  std::vector<std::uint64_t> bits_;
  std::vector<int> degree_;
  std::vector<int> joined_;         ///< so many neighbours at least are joined with one another
  std::vector<std::int64_t> fill_;  ///< twice the pairs that elimination may join
};

}  // namespace loopstone
