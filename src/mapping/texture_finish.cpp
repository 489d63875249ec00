#include "mapping/texture_finish.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "loopstone/base/linear_light.hpp"

namespace loopstone {
namespace {

using Gathered = TileGrid<TextureCell>;
constexpr int kSide = Gathered::kTileSide;

/// A tile with the cells around it, as far as a gap reaches.
class Window {
 public:
  Window(const Gathered& gathered, Cell tile, int reach) : reach_(reach), side_(kSide + 2 * reach) {
    cells_.resize(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_));
    for (int row = 0; row < side_; ++row) {
      for (int column = 0; column < side_; ++column) {
        const Cell cell{tile.column * kSide + column - reach, tile.row * kSide + row - reach};
        const TextureCell* found = gathered.find(cell);
        if (found != nullptr && found->seen()) cells_[index(column, row)] = found->best;
      }
    }
  }
  /// The colour of a seen cell; column and row count from the tile's lower left cell.
  [[nodiscard]] const TextureMode& at(int column, int row) const {
    return cells_[index(column + reach_, row + reach_)];
  }

 private:
  [[nodiscard]] std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(side_) +
           static_cast<std::size_t>(column);
  }
  int reach_;
  int side_;
  std::vector<TextureMode> cells_{};
};

/// From the nearest seen cells on opposite sides, if there are some within the reach together; the
/// nearer counts more.
std::optional<LinearRgb> between_neighbours(const Window& window, int column, int row, int reach) {
  constexpr std::array<std::array<int, 2>, 4> kAxes{{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};
  LinearRgb sum{};
  float weight_sum = 0.0F;
  for (const auto& axis : kAxes) {
    std::array<int, 2> distance{};
    for (std::size_t side = 0; side < 2; ++side) {
      const int sign = side == 0 ? 1 : -1;
      for (int step = 1; step <= reach && distance[side] == 0; ++step) {
        if (window.at(column + sign * step * axis[0], row + sign * step * axis[1]).weight > 0) {
          distance[side] = step;
        }
      }
    }
    if (distance[0] == 0 || distance[1] == 0 || distance[0] + distance[1] > reach + 1) continue;
    for (std::size_t side = 0; side < 2; ++side) {
      const int step = side == 0 ? distance[0] : -distance[1];
      const float weight = 1.0F / static_cast<float>(distance[side]);
      const TextureMode& mode = window.at(column + step * axis[0], row + step * axis[1]);
      for (std::size_t c = 0; c < 3; ++c) sum[c] += weight * static_cast<float>(mode.rgb[c]);
      weight_sum += weight;
    }
  }
  if (weight_sum == 0.0F) return {};
  for (float& channel : sum) channel /= weight_sum;
  return sum;
}

/// The rectangle of cells that are known.
struct Bounds {
  int low_column = std::numeric_limits<int>::max();
  int low_row = std::numeric_limits<int>::max();
  int high_column = std::numeric_limits<int>::min();
  int high_row = std::numeric_limits<int>::min();

  void take(Cell cell) {
    low_column = std::min(low_column, cell.column);
    low_row = std::min(low_row, cell.row);
    high_column = std::max(high_column, cell.column);
    high_row = std::max(high_row, cell.row);
  }
};

}  // namespace

void finish_texture(const Gathered& gathered, const TextureOptions& options, double gain,
                    FloorTexture& texture) {
  const std::vector<std::uint8_t> srgb = srgb_table();
  const int reach = static_cast<int>(std::lround(options.fill_gap_m / options.resolution_m));
  texture.cells = TileGrid<TextureColour>(options.resolution_m);
  Bounds bounds;
  std::int64_t seen = 0;
  std::int64_t filled = 0;
  const auto colour_of = [&](const auto& rgb, std::uint8_t coverage) {
    const auto value = [&](auto channel) {
      const double light = gain * static_cast<double>(channel) + 0.5;
      return srgb[static_cast<std::size_t>(std::clamp(light, 0.0, 65535.0))];
    };
    return TextureColour{value(rgb[0]), value(rgb[1]), value(rgb[2]), coverage};
  };
  // A gap may lie in a tile of which nothing was seen, but only at an edge of one of which
  // something was.
  for (const Cell tile : gathered.tiles()) {
    const Window window(gathered, tile, reach);
    TileGrid<TextureColour>::Tile* target = nullptr;
    for (int row = 0; row < kSide; ++row) {
      for (int column = 0; column < kSide; ++column) {
        const TextureMode& mode = window.at(column, row);
        TextureColour colour;
        if (mode.weight > 0) {
          colour = colour_of(mode.rgb, TextureColour::kSeen);
          ++seen;
        } else if (const auto light = between_neighbours(window, column, row, reach)) {
          colour = colour_of(*light, TextureColour::kFilled);
          ++filled;
        } else {
          continue;
        }
        if (target == nullptr) target = &texture.cells.tile(tile);
        (*target)[TileGrid<TextureColour>::offset_in_tile({column, row})] = colour;
        bounds.take({tile.column * kSide + column, tile.row * kSide + row});
      }
    }
  }
  const double cell_area_m2 = options.resolution_m * options.resolution_m;
  texture.statistics.seen_area_m2 = cell_area_m2 * static_cast<double>(seen);
  texture.statistics.filled_area_m2 = cell_area_m2 * static_cast<double>(filled);
  if (seen == 0) return;
  texture.first_cell = {bounds.low_column, bounds.low_row};
  texture.frame = {
      .origin = options.resolution_m * Eigen::Vector2d(bounds.low_column, bounds.low_row),
      .resolution = options.resolution_m,
      .columns = bounds.high_column - bounds.low_column + 1,
      .rows = bounds.high_row - bounds.low_row + 1};
}

}  // namespace loopstone
