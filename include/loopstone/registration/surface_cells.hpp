#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "loopstone/grid/grid.hpp"

namespace loopstone {

/// Bare points as cells to search on (see correlative_search.hpp): kSurface where a point fell,
/// half way to kUnknown in the eight cells around, kUnknown elsewhere. Nothing is known to be free.
/// \param margin_m  room around the points
/// Throws UsageError when that takes more than 2^28 cells, or no point is finite.
[[nodiscard]] Grid<std::uint8_t> surface_cells(std::span<const Eigen::Vector2d> points,
                                               double cell_m, double margin_m);

}  // namespace loopstone
