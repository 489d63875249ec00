#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <vector>

namespace loopstone {

/// Sets that grow together, as trees: each element has a parent, a root is its own. The root of an
/// element; paths are halved on the way.
/// Cost: nearly constant. Source: Tarjan and van Leeuwen 1984.
template <std::integral Index>
[[nodiscard]] Index root_of(std::vector<Index>& parents, Index element) {
  const auto parent_of = [&](Index of) -> Index& { return parents[static_cast<std::size_t>(of)]; };
  while (parent_of(element) != element)
    element = parent_of(element) = parent_of(parent_of(element));
  return element;
}

/// Makes one set of those of two elements; its root is the lower one of theirs.
template <std::integral Index>
void join(std::vector<Index>& parents, Index a, Index b) {
  const auto [low, high] = std::minmax({root_of(parents, a), root_of(parents, b)});
  parents[static_cast<std::size_t>(high)] = low;
}

}  // namespace loopstone
