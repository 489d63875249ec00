#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "loopstone/base/stamp.hpp"

namespace loopstone {

/// Colours as a camera gives them: sRGB, 8 bits a channel, red green blue interleaved, row 0 at the
/// top.
struct ColourImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb{};

  [[nodiscard]] const std::uint8_t* at(int column, int row) const {
    return &rgb[3 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                     static_cast<std::size_t>(column))];
  }
  [[nodiscard]] bool empty() const { return rgb.empty(); }
};

/// The numbers of a depth camera as CameraModel::encoding explains them; 0 is no measurement. Row 0
/// at the top.
struct RawDepthImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint16_t> numbers{};
};

/// 1 / depth along the optical axis [1/m], 0 where there is no measurement. Row 0 at the top. Over
/// a plane it is linear in column and row, and the noise of a camera that triangulates is the same
/// everywhere.
struct InverseDepthImage {
  int width = 0;
  int height = 0;
  std::vector<float> per_m{};

  [[nodiscard]] float at(int column, int row) const {
    return per_m[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                 static_cast<std::size_t>(column)];
  }
  [[nodiscard]] bool empty() const { return per_m.empty(); }
};

/// The pixels of an RGB-D frame. The two pictures have stamps of their own: the cameras need not be
/// synchronised.
struct RgbdImages {
  Stamp depth_stamp{};
  Stamp colour_stamp{};
  InverseDepthImage depth{};
  ColourImage colour{};
};

}  // namespace loopstone
