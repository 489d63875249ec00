#include "loopstone/grid/grid_frame.hpp"

namespace loopstone {

GridFrame frame_covering(const Eigen::Vector2d& low, const Eigen::Vector2d& high, double resolution,
                         double margin_m) {
  const double first_column = std::floor((low.x() - margin_m) / resolution);
  const double first_row = std::floor((low.y() - margin_m) / resolution);
  const double last_column = std::floor((high.x() + margin_m) / resolution);
  const double last_row = std::floor((high.y() + margin_m) / resolution);
  return {.origin = {first_column * resolution, first_row * resolution},
          .resolution = resolution,
          .columns = static_cast<int>(last_column - first_column) + 1,
          .rows = static_cast<int>(last_row - first_row) + 1};
}

}  // namespace loopstone
