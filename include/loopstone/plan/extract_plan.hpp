#pragma once

#include <cstdint>
#include <vector>

#include "loopstone/grid/grid.hpp"
#include "loopstone/plan/vector_plan.hpp"
#include "loopstone/plan/wall_samples.hpp"
#include "loopstone/slam/decision_numbers.hpp"

namespace loopstone {

/// Draws a map as lines, rooms and doors (docs/plans.md has how).
///
/// \param cells    the map: 100 occupied, 0 free, -1 unknown
/// \param samples  of surfaces, of scans or of the cells themselves
/// Cost: O(samples + cells). The same bytes however many threads there are.
/// Throws UsageError when the map has no occupied cell that is seen from free space.
[[nodiscard]] VectorPlan extract_plan(const Grid<std::int8_t>& cells, const WallSamples& samples);

/// The numbers that plans are drawn by, for the record.
[[nodiscard]] std::vector<NumberGroup> plan_numbers();

}  // namespace loopstone
