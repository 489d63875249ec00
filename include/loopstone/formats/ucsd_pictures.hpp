#pragma once

#include <cstdint>
#include <string>

#include "loopstone/sensor/rgbd_images.hpp"

namespace loopstone {

/// Where the UCSD layout keeps the pictures of one set:
///   FOLDER/dataRGBD/RGB20/rgb20_1.png (8 bits a channel),
///   FOLDER/dataRGBD/Disparity20/disparity20_1.png (16 bits),
/// or Depth20/depth20_1.png where the numbers are distances.
struct UcsdPictures {
  std::string folder;
  int set = 20;
  bool holds_disparity = true;

  /// \param index  of the picture's stamp in KinectN.npz, from 0; names count from 1
  [[nodiscard]] std::string colour_path(std::int64_t index) const;
  [[nodiscard]] std::string depth_path(std::int64_t index) const;
  /// Makes the two folders. Throws DataError.
  void make_folders() const;
  /// Each picture appears whole or not at all. Throws DataError.
  void write_colour(std::int64_t index, const ColourImage& colour) const;
  void write_depth(std::int64_t index, const RawDepthImage& depth) const;
};

}  // namespace loopstone
