#pragma once

#include <array>
#include <cstdint>

#include "loopstone/formats/image.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/slam/map_result.hpp"
#include "report/canvas.hpp"

namespace loopstone {

/// Where nothing was seen.
inline const Colour kUnseenGround = hex_colour(0xd9dde3);

using Rgb = std::array<std::uint8_t, 3>;

/// How a cell is shown that is occupied by so many percent: free white, occupied near black; -1,
/// unknown, and even odds grey.
[[nodiscard]] Rgb cell_rgb(int percent);

/// Which part of a map is shown, and how large: the one place where metres become pixels.
struct MapView {
  Cell low{};  ///< cells low..high are shown, both included
  Cell high{};
  int pixels_per_cell = 1;  ///< 1 when reduced
  int cells_per_pixel = 1;  ///< 1 when enlarged
  int width_px = 1;
  int height_px = 1;
  GridFrame frame{};

  [[nodiscard]] Point pixel_of(const Eigen::Vector2d& point_m) const;
  [[nodiscard]] double pixels_per_metre() const;
};

/// Crops to what was seen and to the path. A few stray beams out of a window do not blow up the
/// view: rows and columns at the edges are cut as long as they hold at most 0.3 % of the observed
/// cells.
[[nodiscard]] MapView view_of(const OccupancyMap& map, const Trajectory& trajectory,
                              int target_side_px, int most_side_px);
[[nodiscard]] MapView view_of(const CellStates& map, const Trajectory& trajectory,
                              int target_side_px, int most_side_px);

/// The map's cells as colours: free white, occupied near black, unknown grey; in between by belief.
/// Where several cells share a pixel the most occupied one shows, so that walls stay.
[[nodiscard]] Image shade_map(const OccupancyMap& map, const MapView& view);
[[nodiscard]] Image shade_map(const CellStates& map, const MapView& view);
/// The map with its contrast taken back, so that what lies over it is read first.
[[nodiscard]] Image paled(Image image);

}  // namespace loopstone
