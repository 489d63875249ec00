#include "formats/mosaic.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace loopstone {
namespace {

struct NamedOrder {
  std::string_view encoding;
  MosaicOrder order;
};
constexpr std::array<NamedOrder, 4> kOrders{{
    {"bayer_rggb8", {0, 0}},
    {"bayer_grbg8", {1, 0}},
    {"bayer_gbrg8", {0, 1}},
    {"bayer_bggr8", {1, 1}},
}};

/// 0 red, 1 green, 2 blue.
std::size_t channel_at(const MosaicOrder& order, int column, int row) {
  const bool in_red_column = column % 2 == order.red_column;
  const bool in_red_row = row % 2 == order.red_row;
  if (in_red_column && in_red_row) return 0;
  return in_red_column || in_red_row ? 1 : 2;
}

}  // namespace

std::optional<MosaicOrder> mosaic_order(std::string_view encoding) {
  const auto* const found = std::ranges::find(kOrders, encoding, &NamedOrder::encoding);
  if (found == kOrders.end()) return std::nullopt;
  return found->order;
}

ColourImage fill_mosaic(const std::function<const std::uint8_t*(int)>& row_at, int width,
                        int height, const MosaicOrder& order) {
  ColourImage colour{width, height, {}};
  colour.rgb.reserve(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      std::array<int, 3> sum{};
      std::array<int, 3> count{};
      for (int v = std::max(0, row - 1); v <= std::min(height - 1, row + 1); ++v) {
        const std::uint8_t* const values = row_at(v);
        for (int u = std::max(0, column - 1); u <= std::min(width - 1, column + 1); ++u) {
          const std::size_t channel = channel_at(order, u, v);
          sum[channel] += values[u];
          ++count[channel];
        }
      }
      const std::size_t own = channel_at(order, column, row);
      for (std::size_t channel = 0; channel < 3; ++channel) {
        const int mean =
            count[channel] == 0 ? 0 : (sum[channel] + count[channel] / 2) / count[channel];
        colour.rgb.push_back(
            static_cast<std::uint8_t>(channel == own ? row_at(row)[column] : mean));
      }
    }
  }
  return colour;
}

}  // namespace loopstone
