#include "floor_files.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "loopstone/base/linear_light.hpp"
#include "loopstone/formats/text_file.hpp"
#include "loopstone/simulation/floor_plan.hpp"

namespace loopstone::app {

namespace {

constexpr double kCell = 0.01;
constexpr std::size_t kMostCells = std::size_t{1} << 28U;  // what readers of PNG pictures take

GridFrame floor_frame(const GridFrame& map) {
  GridFrame frame{.origin = map.origin, .resolution = kCell};
  while (true) {
    frame.columns = static_cast<int>(
        std::lround(std::ceil(map.columns * map.resolution / frame.resolution - 1e-6)));
    frame.rows = static_cast<int>(
        std::lround(std::ceil(map.rows * map.resolution / frame.resolution - 1e-6)));
    if (frame.cell_count() <= kMostCells) return frame;
    frame.resolution *= 2.0;
  }
}

}  // namespace

ColourImage as_colours(const Image& image) {
  ColourImage colours{image.width, image.height, {}};
  colours.rgb.reserve(3 * static_cast<std::size_t>(image.width) *
                      static_cast<std::size_t>(image.height));
  const bool is_grey = image.channels < 3;
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      for (int channel = 0; channel < 3; ++channel) {
        const int sample = image.sample(row, column, is_grey ? 0 : channel);
        colours.rgb.push_back(static_cast<std::uint8_t>(
            std::lround(255.0 * sample / static_cast<double>(image.max_value))));
      }
    }
  }
  return colours;
}

void write_floor(const std::filesystem::path& folder, const FloorPattern& floor,
                 const GridFrame& map) {
  const GridFrame frame = floor_frame(map);
  Image image = make_image(frame.columns, frame.rows, 3);
  const std::vector<std::uint8_t> levels = srgb_table();
  std::size_t at = 0;
  for (int row = frame.rows - 1; row >= 0; --row) {
    for (int column = 0; column < frame.columns; ++column) {
      const Eigen::Vector2d centre = frame.centre_of({column, row});
      const double half = 0.5 * frame.resolution;
      const LinearColour colour =
          floor.mean_over(Extent{centre.array() - half, centre.array() + half});
      for (int channel = 0; channel < 3; ++channel) {
        image.bytes[at++] =
            levels[static_cast<std::size_t>(std::lround(65535.0F * colour[channel]))];
      }
    }
  }
  write_png((folder / "floor.png").string(), image);
  write_text_file((folder / "floor.yaml").string(),
                  fmt::format("image: floor.png\nresolution: {}\norigin: [{}, {}, 0]\n",
                              frame.resolution, frame.origin.x(), frame.origin.y()));
  const Eigen::Vector2d high =
      frame.origin + frame.resolution * Eigen::Vector2d(frame.columns, frame.rows);
  std::string letters = "letter,x_m,y_m,yaw_rad,height_m\n";
  for (const FloorLetter& l : floor.letters_in({frame.origin, high})) {
    letters += fmt::format("{},{:.4f},{:.4f},{:.4f},{:.4f}\n", l.letter, l.map_T_letter.x,
                           l.map_T_letter.y, l.map_T_letter.yaw, l.height_m);
  }
  write_text_file((folder / "floor_letters.csv").string(), letters);
}

}  // namespace loopstone::app
