#include "formats/cloud_columns.hpp"

#include <algorithm>

namespace loopstone {

PointCloud read_columns(const std::array<std::optional<CloudColumn>, 3>& columns,
                        std::size_t points, std::endian order) {
  constexpr std::size_t kBlock = 1024;  // points that stay in the cache from axis to axis
  PointCloud cloud;
  cloud.points.resize(points, Eigen::Vector3d::Zero());
  for (std::size_t begin = 0; begin < points; begin += kBlock) {
    Eigen::Vector3d* const to = cloud.points.data() + begin;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!columns[axis]) continue;
      const CloudColumn& column = *columns[axis];
      load_scalars(column.type, column.begin + begin * column.step, column.step,
                   std::min(kBlock, points - begin), order,
                   [&](std::size_t i, double value) { to[i].data()[axis] = value; });
    }
  }
  return cloud;
}

}  // namespace loopstone
