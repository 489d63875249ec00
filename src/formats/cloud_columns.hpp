#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <optional>

#include "formats/scalar_type.hpp"
#include "loopstone/sensor/point_cloud.hpp"

namespace loopstone {

/// Where the bytes of a coordinate are: point i's at begin + i * step.
struct CloudColumn {
  const char* begin = nullptr;
  std::size_t step = 0;
  ScalarType type{};
};

/// So many points; a coordinate without a column is 0.
[[nodiscard]] PointCloud read_columns(const std::array<std::optional<CloudColumn>, 3>& columns,
                                      std::size_t points, std::endian order);

}  // namespace loopstone
