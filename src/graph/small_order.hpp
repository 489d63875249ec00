#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace loopstone {

/// A graph of some hundred nodes as rows of bits: the degrees that elimination leads to cost next to nothing there.
class SmallGraph {
 public:
  explicit SmallGraph(int size);

  void join(int a, int b);
  /// Each node with each other.
  void join_all(std::span<const int> nodes);

  /// The place of each node when the one with the fewest neighbours is always eliminated next (of equal ones the lowest).
  /// Source: Tinney and Walker 1967, "Direct solutions of sparse network equations", scheme 2.
  [[nodiscard]] std::vector<int> minimum_degree_order() &&;

 private:
  [[nodiscard]] std::uint64_t* row(int node) {
    return bits_.data() + static_cast<std::size_t>(node) * words_;
  }
  void eliminate(int node);

  std::size_t words_ = 0;  ///< in a row
  std::vector<std::uint64_t> bits_;
  std::vector<int> degree_;
};

}  // namespace loopstone
