#pragma once

#include <span>
#include <string>

#include "loopstone/mapping/coloured_point.hpp"

namespace loopstone {

/// A cloud of coloured points as PLY, binary little-endian: x y z as 4-byte floats [m] and red
/// green blue as bytes (sRGB), which CloudCompare, MeshLab and Blender show as they stand. 15 bytes
/// a point.
[[nodiscard]] std::string encode_coloured_cloud(std::span<const ColouredPoint> points);

}  // namespace loopstone
