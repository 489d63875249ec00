#pragma once

#include <span>
#include <string>
#include <string_view>

#include "loopstone/messages/message_types.hpp"
#include "loopstone/sensor/camera_model.hpp"
#include "loopstone/sensor/rgbd_images.hpp"

// Pictures as messages hold them (sensor_msgs/Image, CompressedImage) become ours.

namespace loopstone {

/// What a picture shows, as far as its encoding tells.
enum class PictureContent {
  kUnknown,  ///< an encoding that is not understood
  kColour,   ///< also grey
  kDepth,
  kGrey16,  ///< 16 bits of grey: infrared, or depth by a driver that does not say so
};

/// \param encoding  of an Image ("bgr8", "16UC1"), or the format of a CompressedImage ("jpeg",
///                  "16UC1; compressedDepth png")
[[nodiscard]] PictureContent content_of(std::string_view encoding);

/// Grey is expanded, 16 bits are reduced to 8, alpha is dropped, mosaics (bayer) are filled in.
/// \param where  for errors
/// Throws DataError.
[[nodiscard]] ColourImage to_colour(const msg::Image& message, const std::string& where);
[[nodiscard]] ColourImage to_colour(const msg::CompressedImage& message, const std::string& where);

/// Depth as 16-bit numbers (16UC1, mono16) is in units of the encoding, millimetres when that is of
/// disparities (REP-118); as 32FC1 in metres. Measurements outside of the encoding's range are
/// none.
/// Throws DataError.
[[nodiscard]] InverseDepthImage to_depth(const msg::Image& message, const DepthEncoding& encoding,
                                         const std::string& where);
[[nodiscard]] InverseDepthImage to_depth(const msg::CompressedImage& message,
                                         const DepthEncoding& encoding, const std::string& where);

}  // namespace loopstone
