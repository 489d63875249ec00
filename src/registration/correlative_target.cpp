#include <algorithm>
#include <array>
#include <cmath>

#include "loopstone/registration/correlative_match.hpp"

namespace loopstone {

MaxPyramid make_correlative_target(std::span<const Eigen::Vector2d> points, double half_xy_m,
                                   const CorrelativeTargetOptions& options) {
  Eigen::Vector2d low = points.front();
  Eigen::Vector2d high = points.front();
  for (const auto& point : points) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  const double reach_m = 2.5 * options.blur_m;
  Grid<std::uint8_t> cells(frame_covering(low, high, options.cell_m, reach_m + options.cell_m),
                           kUnknown);
  const GridFrame& frame = cells.frame();
  // The bump is read from a table over the squared distance, as there are many more cells to fill
  // than values to take.
  constexpr int kSteps = 256;
  std::array<std::uint8_t, kSteps + 1> bump{};
  for (int i = 0; i <= kSteps; ++i) {
    const double distance2 = reach_m * reach_m * i / kSteps;
    bump[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(
        kUnknown + std::lround((kSurface - kUnknown) *
                               std::exp(-0.5 * distance2 / (options.blur_m * options.blur_m))));
  }
  const double to_step = kSteps / (reach_m * reach_m);
  const int reach = static_cast<int>(std::ceil(reach_m / options.cell_m));
  for (const auto& point : points) {
    const Cell middle = frame.cell_of(point);
    for (int row = middle.row - reach; row <= middle.row + reach; ++row) {
      for (int column = middle.column - reach; column <= middle.column + reach; ++column) {
        if (!frame.contains({column, row})) continue;
        const double at = to_step * (frame.centre_of({column, row}) - point).squaredNorm();
        if (at > kSteps) continue;
        auto& cell = cells[{column, row}];
        cell = std::max(cell, bump[static_cast<std::size_t>(at)]);
      }
    }
  }
  int levels = 1;
  while (levels < 8 && (1 << levels) * options.cell_m <= half_xy_m) ++levels;
  return MaxPyramid(cells, levels, kUnknown);
}

}  // namespace loopstone
