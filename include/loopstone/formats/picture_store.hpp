#pragma once

#include <cstdint>

#include "loopstone/sensor/camera_model.hpp"
#include "loopstone/sensor/rgbd_images.hpp"

namespace loopstone {

/// Pictures of a recording, by the numbers that RgbdFrame has of them; in any order, from several
/// threads at once.
class PictureStore {
 public:
  virtual ~PictureStore() = default;
  /// Throws DataError that names the recording and the place in it.
  [[nodiscard]] virtual ColourImage colour(std::int64_t message) const = 0;
  /// Numbers of 16 bits are in units of the encoding, millimetres when that is of disparities
  /// (REP-118). Throws DataError.
  [[nodiscard]] virtual InverseDepthImage depth(std::int64_t message,
                                                const DepthEncoding& encoding) const = 0;
};

}  // namespace loopstone
