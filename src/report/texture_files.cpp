#include "report/texture_files.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "formats/png_rows.hpp"
#include "loopstone/formats/coloured_cloud_file.hpp"
#include "loopstone/formats/texture_files.hpp"

namespace loopstone {

void add_texture_files(const FloorTexture& texture, FileSet& files) {
  const GridFrame& frame = texture.frame;
  if (frame.cell_count() > 0) {
    // Row 0 of a picture is its top; the grid's is the bottom.
    const auto row_of = [&](int picture_row) { return frame.rows - 1 - picture_row; };
    files.add("texture.png", "colour of the floor; transparent where nothing was seen",
              [&](AtomicFile& file) {
                write_png_rows(
                    file, frame.columns, frame.rows, 4,
                    [&](int row, std::span<std::uint8_t> samples) {
                      for (int column = 0; column < frame.columns; ++column) {
                        const TextureColour colour = texture.at({column, row_of(row)});
                        const std::size_t at = 4 * static_cast<std::size_t>(column);
                        samples[at] = colour.red;
                        samples[at + 1] = colour.green;
                        samples[at + 2] = colour.blue;
                        samples[at + 3] = colour.coverage > 0 ? 255 : 0;
                      }
                    },
                    kPngCompression);
              });
    files.add("coverage.png",
              "white where the floor was seen, grey where a gap was filled, black elsewhere",
              [&](AtomicFile& file) {
                write_png_rows(
                    file, frame.columns, frame.rows, 1,
                    [&](int row, std::span<std::uint8_t> samples) {
                      for (int column = 0; column < frame.columns; ++column) {
                        samples[static_cast<std::size_t>(column)] =
                            texture.at({column, row_of(row)}).coverage;
                      }
                    },
                    kPngCompression);
              });
    files.add("texture.yaml", "frame of texture.png and coverage.png",
              format_texture_yaml(frame, "texture.png", "coverage.png"));
    files.add("texture.pgw", "world file of texture.png for GIS programs, metres of the map frame",
              format_world_file(frame));
  }
  if (!texture.cloud.empty()) {
    files.add("cloud.ply", "everything the camera saw, in colour",
              encode_coloured_cloud(texture.cloud));
  }
}

}  // namespace loopstone
