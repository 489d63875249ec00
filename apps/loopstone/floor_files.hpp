#pragma once

#include <filesystem>

#include "loopstone/formats/image.hpp"
#include "loopstone/grid/grid_frame.hpp"
#include "loopstone/sensor/rgbd_images.hpp"
#include "loopstone/simulation/floor_pattern.hpp"

namespace loopstone::app {

/// A picture of any kind as 8-bit colours.
[[nodiscard]] ColourImage as_colours(const Image& image);

/// The true colours of the floor for a program that maps them: floor.png, floor.yaml (as ROS
/// map_server reads it) and floor_letters.csv, over the area of a map, in cells of 1 cm, or 2, 4
/// ... cm where that would be too many.
void write_floor(const std::filesystem::path& folder, const FloorPattern& floor,
                 const GridFrame& map);

}  // namespace loopstone::app
