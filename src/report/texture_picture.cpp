#include "loopstone/report/texture_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "loopstone/base/linear_light.hpp"
#include "report/map_view.hpp"
#include "report/path_line.hpp"
#include "report/picture_parts.hpp"

namespace loopstone {
namespace {

constexpr double kOccupied = 0.6;  ///< log-odds from which on a cell is drawn as wall
constexpr Rgb kWall{0x16, 0x1b, 0x26};

/// Without a map: where the floor was seen, in cells of 5 cm.
OccupancyMap map_of_coverage(const FloorTexture& texture) {
  constexpr double kCell_m = 0.05;
  const Eigen::Vector2d low = texture.frame.origin;
  const Eigen::Vector2d high =
      low + texture.frame.resolution * Eigen::Vector2d(texture.frame.columns, texture.frame.rows);
  const GridFrame frame = frame_covering(low, high, kCell_m);
  OccupancyMap map{Grid<float>(frame, 0.0F), Grid<std::uint8_t>(frame, 0)};
  for (int row = 0; row < texture.frame.rows; ++row) {
    for (int column = 0; column < texture.frame.columns; ++column) {
      if (texture.at({column, row}).coverage == 0) continue;
      const Cell cell = frame.cell_of(texture.frame.centre_of({column, row}));
      if (frame.contains(cell)) map.observed[cell] = 1;
    }
  }
  return map;
}

/// Mean light of the texture's cells in a square of the map; coverage tells whether there are any.
class FloorShader {
 public:
  explicit FloorShader(const FloorTexture& texture)
      : texture_(texture), light_(linear_light_table()), srgb_(srgb_table()) {}

  /// The colour over what was there, by the share of the square that is known.
  [[nodiscard]] Rgb over(const Rgb& ground, const Eigen::Vector2d& low, double side_m) const {
    const GridFrame& frame = texture_.frame;
    const double per_cell = 1.0 / frame.resolution;
    const Cell first = frame.cell_of(low + Eigen::Vector2d::Constant(1e-9));
    const int steps = std::max(1, static_cast<int>(std::lround(side_m * per_cell)));
    std::array<double, 3> sum{};
    int known = 0;
    for (int row = first.row; row < first.row + steps; ++row) {
      for (int column = first.column; column < first.column + steps; ++column) {
        if (!frame.contains({column, row})) continue;
        const TextureColour colour = texture_.at({column, row});
        if (colour.coverage == 0) continue;
        ++known;
        sum[0] += light_[colour.red];
        sum[1] += light_[colour.green];
        sum[2] += light_[colour.blue];
      }
    }
    if (known == 0) return ground;
    const double share = static_cast<double>(known) / (steps * steps);
    Rgb mixed{};
    for (std::size_t c = 0; c < 3; ++c) {
      const double light = share * sum[c] / known + (1.0 - share) * light_[ground[c]];
      mixed[c] = srgb_[static_cast<std::size_t>(std::lround(light))];
    }
    return mixed;
  }

 private:
  const FloorTexture& texture_;
  std::array<std::uint16_t, 256> light_;
  std::vector<std::uint8_t> srgb_;
};

/// The map's picture with the floor laid over it, but for the walls.
void lay_floor(const FloorTexture& texture, const OccupancyMap& map, const MapView& view,
               Image& image) {
  const FloorShader shader(texture);
  const double pixel_m = 1.0 / view.pixels_per_metre();
  const Eigen::Vector2d corner =
      view.frame.origin + view.frame.resolution * Eigen::Vector2d(view.low.column, view.low.row);
  for (int y = 0; y < view.height_px; ++y) {
    for (int x = 0; x < view.width_px; ++x) {
      const Eigen::Vector2d low = corner + pixel_m * Eigen::Vector2d(x, view.height_px - 1 - y);
      const Cell cell =
          map.log_odds.frame().cell_of(low + Eigen::Vector2d::Constant(0.5 * pixel_m));
      std::uint8_t* pixel =
          &image.bytes[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(view.width_px) +
                            static_cast<std::size_t>(x))];
      const bool is_wall = static_cast<double>(map.log_odds.value_or(cell, 0.0F)) > kOccupied;
      const Rgb colour =
          is_wall ? kWall : shader.over({pixel[0], pixel[1], pixel[2]}, low, pixel_m);
      std::copy(colour.begin(), colour.end(), pixel);
    }
  }
}

}  // namespace

Image draw_texture_picture(const FloorTexture& texture, const OccupancyMap& given_map,
                           const Trajectory& trajectory, const TexturePictureOptions& options) {
  const OccupancyMap map = given_map.log_odds.empty() ? map_of_coverage(texture) : given_map;
  const MapView view = view_of(map, trajectory, options.target_side_px, options.most_side_px);
  const PictureSizes sizes(std::max(view.width_px, view.height_px));
  const int width = std::max(view.width_px, static_cast<int>(16.0 * sizes.text));
  Footer footer(sizes, width);
  footer.add_scale_bar(view.pixels_per_metre());
  footer.add_axes();

  Canvas canvas(width, view.height_px + static_cast<int>(footer.height()), kUnseenGround);
  Image ground = shade_map(map, view);
  if (texture.frame.cell_count() > 0) lay_floor(texture, map, view, ground);
  canvas.paste(ground, 0, 0);
  if (options.trajectory && !trajectory.empty()) {
    draw_path_line(trajectory, view, 0.6 * sizes.path, canvas);
    draw_start_and_end(trajectory.front().pose, trajectory.back().pose, view, sizes, canvas);
  }
  footer.draw(canvas, view.height_px);
  return canvas.image();
}

}  // namespace loopstone
