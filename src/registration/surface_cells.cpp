#include "loopstone/registration/surface_cells.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include "loopstone/base/error.hpp"
#include "loopstone/base/number_text.hpp"
#include "loopstone/registration/correlative_search.hpp"
#include "loopstone/sensor/point_cloud.hpp"

namespace loopstone {

Grid<std::uint8_t> surface_cells(std::span<const Eigen::Vector2d> points, double cell_m,
                                 double margin_m) {
  constexpr double kMostCells = 1U << 28;
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = -low;
  for (const Eigen::Vector2d& point : points) {
    if (!is_usable_point(point)) continue;
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  if (!(low.x() <= high.x())) throw UsageError("there are no finite points to search on");
  const Eigen::Vector2d size = (high - low) / cell_m;
  if (!((size.x() + 3.0) * (size.y() + 3.0) < kMostCells)) {
    throw UsageError("cells of " + number_text(cell_m) + " m are too small for points that are " +
                     number_text((high - low).maxCoeff(), 4) + " m apart");
  }
  constexpr std::uint8_t kBeside = (kSurface + kUnknown) / 2;
  Grid<std::uint8_t> cells(frame_covering(low, high, cell_m, margin_m + cell_m), kUnknown);
  for (const Eigen::Vector2d& point : points) {
    if (!is_usable_point(point)) continue;
    const Cell centre = cells.frame().cell_of(point);
    for (int row = centre.row - 1; row <= centre.row + 1; ++row) {
      for (int column = centre.column - 1; column <= centre.column + 1; ++column) {
        const Cell cell{column, row};
        if (!cells.frame().contains(cell)) continue;
        cells[cell] = std::max(cells[cell], cell == centre ? kSurface : kBeside);
      }
    }
  }
  return cells;
}

}  // namespace loopstone
