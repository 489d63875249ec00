#pragma once

#include <span>
#include <utility>
#include <vector>

#include "loopstone/graph/block_system.hpp"

namespace loopstone {

/// fill_reducing_order for pairs that are known to differ.
[[nodiscard]] std::vector<int> fill_reducing_order_of_unique(
    int size, std::span<const std::pair<int, int>> pairs);

}  // namespace loopstone
