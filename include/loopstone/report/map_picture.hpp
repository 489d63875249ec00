#pragma once

#include <span>

#include "loopstone/formats/image.hpp"
#include "loopstone/localization/landmark_mapping.hpp"
#include "loopstone/slam/map_result.hpp"

namespace loopstone {

/// How a map becomes the picture that a person looks at.
struct MapPictureOptions {
  int target_side_px = 2000;  ///< small maps are enlarged by a whole factor up to about this
  int most_side_px = 4000;    ///< large maps are reduced by a whole factor to stay below
  bool trajectory = true;
  bool loop_closures = true;
};

/// The occupancy map cropped to what was seen, the path coloured from start to end, accepted loop
/// closures, scale bar, axes and legend. 8-bit RGB; the top of the picture is the largest y.
/// \param landmarks  dots, where there are any
[[nodiscard]] Image draw_map_picture(const MapResult& result, const MapPictureOptions& options = {},
                                     std::span<const FoundLandmark> landmarks = {});

}  // namespace loopstone
