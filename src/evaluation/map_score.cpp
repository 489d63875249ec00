#include "loopstone/evaluation/map_score.hpp"

#include <algorithm>

#include "loopstone/grid/distance_transform.hpp"
#include "loopstone/grid/grid_cells.hpp"

namespace loopstone {

namespace {

bool is_surface(const Grid<CellState>& map, Cell cell) {
  if (map[cell] != CellState::kOccupied) return false;
  for (int row = -1; row <= 1; ++row) {
    for (int column = -1; column <= 1; ++column) {
      const Cell neighbour{cell.column + column, cell.row + row};
      if (map.value_or(neighbour, CellState::kUnknown) == CellState::kFree) return true;
    }
  }
  return false;
}

template <typename Chosen>
Grid<std::uint8_t> mask_of(const Grid<CellState>& map, Chosen&& chosen) {
  Grid<std::uint8_t> mask(map.frame());
  for_each_cell(map.frame(), [&](Cell cell) { mask[cell] = chosen(map, cell) ? 1 : 0; });
  return mask;
}

/// How far cells of one map are from marked cells of the other.
struct Nearness {
  std::int64_t cells = 0;
  std::int64_t within_tolerance = 0;
  double sum_of_distances_m = 0.0;

  [[nodiscard]] double share() const {
    return cells == 0 ? 0.0 : static_cast<double>(within_tolerance) / static_cast<double>(cells);
  }
  [[nodiscard]] double mean_m() const {
    return cells == 0 ? 0.0 : sum_of_distances_m / static_cast<double>(cells);
  }
};

Nearness measure(const Grid<std::uint8_t>& from, const Grid<std::uint8_t>& to,
                 const Pose2& to_T_from, double tolerance_m, double largest_distance_m) {
  const Grid<float> distance_m = distance_transform(to);
  const auto largest = static_cast<float>(largest_distance_m);
  Nearness result;
  for_each_cell(from.frame(), [&](Cell cell) {
    if (from[cell] == 0) return;
    const Cell there = to.frame().cell_of(to_T_from * from.frame().centre_of(cell));
    // Outside the other map nothing is marked; how near its edge lies does not matter within the
    // cap.
    const double distance = std::min(distance_m.value_or(there, largest), largest);
    ++result.cells;
    // Distances are float: a tolerance of exactly two cells must include two cells.
    if (distance <= tolerance_m + 1e-5) ++result.within_tolerance;
    result.sum_of_distances_m += distance;
  });
  return result;
}

/// `map` as seen in the cells of another frame.
CellState state_at(const Grid<CellState>& map, const Eigen::Vector2d& point_map) {
  return map.value_or(map.frame().cell_of(point_map), CellState::kUnknown);
}

double free_overlap(const Grid<CellState>& map, const Grid<CellState>& truth,
                    const Pose2& truth_T_map) {
  // Areas: intersection in the truth's cells; union = both areas less the intersection.
  const Pose2 map_T_truth = truth_T_map.inverse();
  double in_both = 0.0;
  double in_truth = 0.0;
  double in_map = 0.0;
  for_each_cell(truth.frame(), [&](Cell cell) {
    if (truth[cell] != CellState::kFree) return;
    in_truth += 1.0;
    if (state_at(map, map_T_truth * truth.frame().centre_of(cell)) == CellState::kFree)
      in_both += 1.0;
  });
  for_each_cell(map.frame(),
                [&](Cell cell) { in_map += map[cell] == CellState::kFree ? 1.0 : 0.0; });
  const double truth_cell_m2 = truth.frame().resolution * truth.frame().resolution;
  const double map_cell_m2 = map.frame().resolution * map.frame().resolution;
  const double either_m2 = (in_truth - in_both) * truth_cell_m2 + in_map * map_cell_m2;
  return either_m2 > 0.0 ? std::min(1.0, in_both * truth_cell_m2 / either_m2) : 0.0;
}

}  // namespace

Grid<CellState> classify_cells(const Grid<std::int8_t>& occupancy_percent) {
  Grid<CellState> states(occupancy_percent.frame(), CellState::kUnknown);
  for (std::size_t i = 0; i < states.cells().size(); ++i) {
    const std::int8_t percent = occupancy_percent.cells()[i];
    if (percent >= 65) states.cells()[i] = CellState::kOccupied;
    if (percent >= 0 && percent <= 20) states.cells()[i] = CellState::kFree;
  }
  return states;
}

MapScore score_map(const Grid<CellState>& map, const Grid<CellState>& truth,
                   const Pose2& truth_T_map, double tolerance_m, double largest_distance_m) {
  const Grid<std::uint8_t> occupied =
      mask_of(map, [](const auto& grid, Cell cell) { return grid[cell] == CellState::kOccupied; });
  const Grid<std::uint8_t> true_occupied = mask_of(
      truth, [](const auto& grid, Cell cell) { return grid[cell] == CellState::kOccupied; });
  const Grid<std::uint8_t> surface = mask_of(truth, is_surface);

  // A beam may end a little inside a thick wall, so precision asks for any true occupied cell;
  // recall only for surfaces.
  const Nearness found =
      measure(occupied, true_occupied, truth_T_map, tolerance_m, largest_distance_m);
  const Nearness seen =
      measure(surface, occupied, truth_T_map.inverse(), tolerance_m, largest_distance_m);

  MapScore score;
  score.precision = found.share();
  score.recall = seen.share();
  const double sum = score.precision + score.recall;
  score.f1 = sum > 0.0 ? 2.0 * score.precision * score.recall / sum : 0.0;
  score.free_iou = free_overlap(map, truth, truth_T_map);
  score.mean_distance_m = found.mean_m();
  score.mean_gap_m = seen.mean_m();
  score.occupied_cells = found.cells;
  score.surface_cells = seen.cells;
  return score;
}

}  // namespace loopstone
