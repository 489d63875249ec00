#pragma once

#include <cstdint>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/grid/grid.hpp"

namespace loopstone {

/// The distance from each cell's centre to the centre of the nearest cell whose value is not 0 [m];
/// +inf everywhere when there is no such cell. Exact: squared distances are whole numbers of cells
/// until the last square root.
/// Cost: O(cells). The same bytes for any number of threads.
/// Source: Felzenszwalb and Huttenlocher 2012, "Distance transforms of sampled functions", section
/// 2.1.
[[nodiscard]] Grid<float> distance_transform(const Grid<std::uint8_t>& occupied,
                                             Threads threads = {});

}  // namespace loopstone
