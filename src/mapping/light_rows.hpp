#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "loopstone/sensor/rgbd_images.hpp"
#include "mapping/texture_cell.hpp"

namespace loopstone {

/// A picture in linear light, as running sums along its rows, so that the mean over an upright box
/// costs two reads a row however wide the box is. Source: Crow 1984, "Summed-area tables for
/// texture mapping", in one direction only: boxes are a few rows high, and sums stay small enough
/// to be exact.
class LightRows {
 public:
  LightRows();

  /// Rows [first, end) of the picture; the others are not read.
  void assign(const ColourImage& picture, int first_row, int end_row);

  /// Mean over |u - centre| <= width / 2, |v - centre| <= height / 2; pixel k covers [k - 1/2, k +
  /// 1/2]. The box lies within the rows assigned and the columns.
  [[nodiscard]] LinearRgb mean(float u, float v, float width, float height) const {
    const float left = u - 0.5F * width + 0.5F;  // in sums: k pixels end at k
    const float right = left + width;
    const float top = v - 0.5F * height + 0.5F;
    const float bottom = top + height;
    const int column_0 = std::clamp(static_cast<int>(left), 0, columns_ - 1);
    const int column_1 = std::clamp(static_cast<int>(right), 0, columns_ - 1);
    const float share_0 = left - static_cast<float>(column_0);
    const float share_1 = right - static_cast<float>(column_1);
    const int row_0 = std::clamp(static_cast<int>(top), 0, rows_ - 1);
    const int row_1 = std::clamp(static_cast<int>(bottom), 0, rows_ - 1);
    Sum sum{};
    for (int row = row_0; row <= row_1; ++row) {
      const float from = std::max(top, static_cast<float>(row));
      const float to = std::min(bottom, static_cast<float>(row + 1));
      const float weight = to - from;
      const Sum* sums = &sums_[static_cast<std::size_t>(row) * stride_];
      const Sum& a0 = sums[column_0];
      const Sum& a1 = sums[column_0 + 1];
      const Sum& b0 = sums[column_1];
      const Sum& b1 = sums[column_1 + 1];
      for (std::size_t c = 0; c < 4; ++c) {
        sum[c] +=
            weight * ((b0[c] - a0[c]) + share_1 * (b1[c] - b0[c]) - share_0 * (a1[c] - a0[c]));
      }
    }
    const float scale = kUnit / (width * height);
    return {scale * sum[0], scale * sum[1], scale * sum[2]};
  }

 private:
  /// Light is summed in steps of so much: whole numbers below 2^24, which floats hold exactly, up
  /// to 1024 columns.
  static constexpr float kUnit = 4.0F;
  /// Red, green, blue, nothing.
  using Sum = std::array<float, 4>;

  std::array<float, 256> light_{};
  int columns_ = 0;
  int rows_ = 0;
  std::size_t stride_ = 0;
  std::vector<Sum> sums_{};
};

}  // namespace loopstone
