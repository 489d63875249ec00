#pragma once

#include "loopstone/formats/image.hpp"
#include "loopstone/mapping/floor_texture.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/odometry/trajectory.hpp"

namespace loopstone {

struct TexturePictureOptions {
  int target_side_px = 1600;  ///< of the longer side, when cells can be enlarged by a whole number
  int most_side_px = 3000;
  bool trajectory = true;
};

/// The floor in its colours with the walls of the map over it, the path of the robot, scale bar and
/// axes.
/// \param map  may be empty: then the picture shows the floor alone
[[nodiscard]] Image draw_texture_picture(const FloorTexture& texture, const OccupancyMap& map,
                                         const Trajectory& trajectory,
                                         const TexturePictureOptions& options = {});

}  // namespace loopstone
