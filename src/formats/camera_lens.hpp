#pragma once

#include <string>

#include "loopstone/messages/message_types.hpp"
#include "loopstone/sensor/camera_model.hpp"

namespace loopstone {

/// The lens that a sensor_msgs/CameraInfo tells.
struct ToldLens {
  LensModel lens{};
  double worst_px = 0.0;  ///< by which our model of the lens misses the told one, anywhere
  std::string fault{};    ///< why there is none; empty when there is
};

/// Of plumb_bob as it is; of rational_polynomial, equidistant and fisheye by the Brown-Conrady lens
/// that is nearest over the picture (least squares of the radius at equal steps of it). Binning and
/// regions of interest are considered.
/// \param is_rectified  the picture's rays were straightened: the matrix P holds, without
///                      distortion
[[nodiscard]] ToldLens lens_of(const msg::CameraInfo& info, bool is_rectified);

/// The lens of the same camera that gives pictures of another size.
[[nodiscard]] LensModel scaled(const LensModel& lens, int width_px, int height_px);

}  // namespace loopstone
