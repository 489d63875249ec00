#include "loopstone/registration/likelihood_field.hpp"

#include <algorithm>
#include <cmath>

#include "loopstone/grid/distance_transform.hpp"

namespace loopstone {

namespace {

/// Cells of twice the size, with the field's value at their centres: the mean of the four cells
/// around each.
Grid<float> halved(const Grid<float>& fine) {
  GridFrame frame = fine.frame();
  frame.resolution *= 2.0;
  frame.columns = (frame.columns + 1) / 2;
  frame.rows = (frame.rows + 1) / 2;
  Grid<float> coarse(frame);
  const int last_column = fine.frame().columns - 1;
  const int last_row = fine.frame().rows - 1;
  for (int row = 0; row < frame.rows; ++row) {
    const int upper = std::min(2 * row + 1, last_row);
    for (int column = 0; column < frame.columns; ++column) {
      const int right = std::min(2 * column + 1, last_column);
      coarse[{column, row}] = 0.25F * (fine[{2 * column, 2 * row}] + fine[{right, 2 * row}] +
                                       fine[{2 * column, upper}] + fine[{right, upper}]);
    }
  }
  return coarse;
}

}  // namespace

Grid<std::uint8_t> visible_walls(const Grid<std::int8_t>& occupancy, int occupied_percent) {
  const GridFrame& frame = occupancy.frame();
  const auto is_free = [&](std::int8_t percent) {
    return percent >= 0 && percent < occupied_percent;
  };
  const bool any_free = std::any_of(occupancy.cells().begin(), occupancy.cells().end(), is_free);
  Grid<std::uint8_t> walls(frame, 0);
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      if (occupancy[{column, row}] < occupied_percent) continue;
      bool seen = !any_free;
      for (int r = row - 1; r <= row + 1 && !seen; ++r) {
        for (int c = column - 1; c <= column + 1 && !seen; ++c)
          seen = is_free(occupancy.value_or({c, r}, -1));
      }
      walls[{column, row}] = seen ? 1 : 0;
    }
  }
  return walls;
}

std::vector<Eigen::Vector2d> wall_points(const Grid<std::int8_t>& occupancy, int occupied_percent) {
  const Grid<std::uint8_t> walls = visible_walls(occupancy, occupied_percent);
  std::vector<Eigen::Vector2d> points;
  for (int row = 0; row < walls.frame().rows; ++row) {
    for (int column = 0; column < walls.frame().columns; ++column) {
      if (walls[{column, row}] != 0) points.push_back(walls.frame().centre_of({column, row}));
    }
  }
  return points;
}

MapField::MapField(const Grid<std::int8_t>& occupancy, const MapFieldOptions& options)
    : reach_m_(options.reach_m) {
  levels_.push_back(distance_transform(visible_walls(occupancy, options.occupied_percent)));
  const auto farthest =
      static_cast<float>(options.reach_m * static_cast<double>(1U << (options.levels - 1)));
  for (float& distance : levels_.front().cells()) distance = std::min(distance, farthest);
  for (int level = 1; level < options.levels; ++level) levels_.push_back(halved(levels_.back()));
}

std::size_t MapField::memory_bytes() const {
  std::size_t bytes = 0;
  for (const auto& level : levels_) bytes += level.cells().size() * sizeof(float);
  return bytes;
}

FieldSample MapField::sample(std::size_t level, const Eigen::Vector2d& point) const {
  const Grid<float>& grid = levels_[level];
  const GridFrame& frame = grid.frame();
  const double reach = reach_m(level);
  FieldSample sample{.distance_m = reach};
  // In cells from the centre of cell (0, 0).
  const double x = (point.x() - frame.origin.x()) / frame.resolution - 0.5;
  const double y = (point.y() - frame.origin.y()) / frame.resolution - 0.5;
  if (!(x >= 0.0 && y >= 0.0 && x < frame.columns - 1 && y < frame.rows - 1)) return sample;
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(y);
  const double right = x - column;
  const double up = y - row;
  const float* const corner = &grid.cells()[frame.index_of({column, row})];
  const double low_left = static_cast<double>(corner[0]);
  const double low_right = static_cast<double>(corner[1]);
  const double high_left = static_cast<double>(corner[frame.columns]);
  const double high_right = static_cast<double>(corner[frame.columns + 1]);
  const double low = low_left + right * (low_right - low_left);
  const double high = high_left + right * (high_right - high_left);
  const double distance = low + up * (high - low);
  if (!(distance < reach)) return sample;
  sample.distance_m = distance;
  const double along_x =
      (low_right - low_left) + up * ((high_right - high_left) - (low_right - low_left));
  sample.gradient = Eigen::Vector2d(along_x, high - low) / frame.resolution;
  return sample;
}

}  // namespace loopstone
