#pragma once

#include <functional>
#include <vector>

#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/rgbd_images.hpp"

namespace loopstone {

/// The RGB-D frames of a recording, whose pixels are loaded one frame at a time.
struct RgbdSource {
  std::vector<RgbdFrame> frames{};  ///< by stamp
  /// Called from several threads. Throws what loading throws.
  std::function<RgbdImages(const RgbdFrame&)> load{};
};

}  // namespace loopstone
