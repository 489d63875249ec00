#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace loopstone {

/// The share of full light, 0 to 1, that an sRGB value of 0 to 1 stands for. Source: IEC 61966-2-1.
[[nodiscard]] inline double linear_of_srgb(double value) {
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}
/// Its inverse.
[[nodiscard]] inline double srgb_of_linear(double light) {
  return light <= 0.0031308 ? light * 12.92 : 1.055 * std::pow(light, 1.0 / 2.4) - 0.055;
}

/// Linear light of each 8-bit sRGB value, 0 to 65535. Colours are averaged in light, not in sRGB:
/// the mean of black and white is what an eye sees from afar.
[[nodiscard]] inline std::array<std::uint16_t, 256> linear_light_table() {
  std::array<std::uint16_t, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    table[i] = static_cast<std::uint16_t>(
        std::lround(65535.0 * linear_of_srgb(static_cast<double>(i) / 255.0)));
  }
  return table;
}

/// 8-bit sRGB of each of 65536 steps of light.
[[nodiscard]] inline std::vector<std::uint8_t> srgb_table() {
  std::vector<std::uint8_t> table(65536);
  for (std::size_t i = 0; i < table.size(); ++i) {
    table[i] = static_cast<std::uint8_t>(
        std::lround(255.0 * srgb_of_linear(static_cast<double>(i) / 65535.0)));
  }
  return table;
}

}  // namespace loopstone
