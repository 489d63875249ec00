#include <algorithm>
#include <cmath>

#include "loopstone/registration/map_match.hpp"

namespace loopstone {

namespace {

constexpr int kLevels = 5;

/// The map's cells as a search sees them, in cells of the search: the least distance to a wall
/// within the cell decides, as a point anywhere in it must not be judged too harshly.
struct SearchGrids {
  Grid<std::uint8_t> values;
  Grid<std::uint8_t> standable;
};

std::uint8_t value_of(double distance_m, bool seen, double tolerance_m) {
  const double ratio = std::clamp((2.5 * tolerance_m - distance_m) / (1.5 * tolerance_m), 0.0, 1.0);
  const double base = seen ? kContradiction : kUnknown;
  return static_cast<std::uint8_t>(std::lround(base + (kSurface - base) * ratio));
}

SearchGrids make_grids(const Grid<std::int8_t>& occupancy, const MapField& field,
                       const MapSearchOptions& options) {
  const GridFrame& fine = occupancy.frame();
  GridFrame frame = fine;
  frame.resolution = std::max(options.cell_m, fine.resolution);
  const double ratio = frame.resolution / fine.resolution;
  frame.columns = static_cast<int>(std::ceil(fine.columns / ratio - 1e-9));
  frame.rows = static_cast<int>(std::ceil(fine.rows / ratio - 1e-9));
  SearchGrids grids{Grid<std::uint8_t>(frame, kUnknown), Grid<std::uint8_t>(frame, 0)};
  const int occupied = options.field.occupied_percent;
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      const Eigen::Vector2d centre = frame.centre_of({column, row});
      const double half = 0.5 * frame.resolution;
      const Cell low = fine.cell_of(centre.array() - half + 1e-6 * half);
      const Cell high = fine.cell_of(centre.array() + half - 1e-6 * half);
      bool any_free = false;
      bool seen = false;
      for (int r = low.row; r <= high.row; ++r) {
        for (int c = low.column; c <= high.column; ++c) {
          const std::int8_t percent = occupancy.value_or({c, r}, -1);
          any_free = any_free || (percent >= 0 && percent < occupied);
          seen = seen || percent >= 0;
        }
      }
      const FieldSample nearest = field.sample(field.level_count() - 1, centre);
      const double distance = field.frame().contains(fine.cell_of(centre))
                                  ? static_cast<double>(field.distances()[fine.cell_of(centre)])
                                  : nearest.distance_m;
      grids.values[{column, row}] = value_of(distance, seen, options.tolerance_m);
      grids.standable[{column, row}] = any_free && distance >= options.robot_radius_m ? 1 : 0;
    }
  }
  return grids;
}

}  // namespace

MapSearch::MapSearch(const Grid<std::int8_t>& occupancy, const MapSearchOptions& options)
    : field_(occupancy, options.field), pyramid_(Grid<std::uint8_t>(GridFrame{}), 1, kUnknown) {
  SearchGrids grids = make_grids(occupancy, field_, options);
  standable_ = std::move(grids.standable);
  pyramid_ = MaxPyramid(grids.values, kLevels, kUnknown);
}

std::size_t MapSearch::memory_bytes() const {
  return field_.memory_bytes() + pyramid_.memory_bytes() + standable_.cells().size();
}

}  // namespace loopstone
