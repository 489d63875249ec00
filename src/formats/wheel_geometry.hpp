#pragma once

#include <optional>
#include <string_view>

#include "formats/frame_tree.hpp"

namespace loopstone {

/// What frames of wheels tell; nothing where they don't.
struct WheelGeometry {
  std::optional<double> track_width_m{};  ///< between the middles of left and right wheels
  std::optional<double> radius_m{};       ///< how high their axles are above the robot's footprint
};

/// Wheels are found by their frames' names, the floor by a frame that is called a footprint: where
/// there is none, nothing tells the radius. Frames that contradict each other (a left wheel on the
/// right side, axles of different heights) tell nothing.
/// \param base  the robot's frame
[[nodiscard]] WheelGeometry wheel_geometry(const FrameTree& frames, std::string_view base);

}  // namespace loopstone
