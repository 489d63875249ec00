#pragma once

#include <span>
#include <utility>
#include <vector>

namespace loopstone {

/// An order of elimination with little fill: result[i] is the place of i. Nodes of at most two neighbours, the long chains
/// of a pose graph, go first, in rounds of nodes that do not touch one another, so that the elimination tree stays
/// shallow; what is left is ordered by approximate minimum degree (Amestoy, Davis and Duff 1996).
/// Pairs may repeat and may join a node to itself.
[[nodiscard]] std::vector<int> fill_reducing_order(int size,
                                                   std::span<const std::pair<int, int>> pairs);
/// The same for pairs that are known to differ.
[[nodiscard]] std::vector<int> fill_reducing_order_of_unique(
    int size, std::span<const std::pair<int, int>> pairs);

}  // namespace loopstone
