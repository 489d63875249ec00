#include "mapping/light_rows.hpp"

#include <cmath>

#include "loopstone/base/linear_light.hpp"

namespace loopstone {

LightRows::LightRows() {
  const auto table = linear_light_table();
  for (std::size_t i = 0; i < light_.size(); ++i) {
    light_[i] = std::round(static_cast<float>(table[i]) / kUnit);
  }
}

void LightRows::assign(const ColourImage& picture, int first_row, int end_row) {
  columns_ = picture.width;
  rows_ = picture.height;
  stride_ = static_cast<std::size_t>(columns_) + 1;
  sums_.resize(stride_ * static_cast<std::size_t>(rows_));
  for (int row = std::max(0, first_row); row < std::min(end_row, rows_); ++row) {
    const std::uint8_t* from = picture.at(0, row);
    Sum* to = &sums_[static_cast<std::size_t>(row) * stride_];
    Sum sum{};
    to[0] = sum;
    for (int column = 0; column < columns_; ++column, from += 3) {
      sum[0] += light_[from[0]];
      sum[1] += light_[from[1]];
      sum[2] += light_[from[2]];
      to[column + 1] = sum;
    }
  }
}

}  // namespace loopstone
