#include "loopstone/grid/grid_frame.hpp"

#include <cmath>
#include <string>

#include "loopstone/base/error.hpp"
#include "loopstone/base/number_text.hpp"

namespace loopstone {

namespace {

constexpr double kMostCells = 1073741824.0;

[[noreturn]] void refuse_size(double columns, double rows, double resolution) {
  throw UsageError("a grid over " + number_text(columns * resolution, 4) + " m x " +
                   number_text(rows * resolution, 4) + " m with cells of " +
                   number_text(resolution) +
                   " m is too large: some coordinates are wrong, or the cells are too small");
}

}  // namespace

GridFrame frame_covering(const Eigen::Vector2d& low, const Eigen::Vector2d& high, double resolution,
                         double margin_m) {
  const double first_column = std::floor((low.x() - margin_m) / resolution);
  const double first_row = std::floor((low.y() - margin_m) / resolution);
  const double last_column = std::floor((high.x() + margin_m) / resolution);
  const double last_row = std::floor((high.y() + margin_m) / resolution);
  const double columns = last_column - first_column + 1.0;
  const double rows = last_row - first_row + 1.0;
  // Written so that NaN is too large.
  const bool fits = columns <= kMostCells && rows <= kMostCells && columns * rows <= kMostCells;
  if (!fits) refuse_size(columns, rows, resolution);
  return {.origin = {first_column * resolution, first_row * resolution},
          .resolution = resolution,
          .columns = static_cast<int>(columns),
          .rows = static_cast<int>(rows)};
}

}  // namespace loopstone
