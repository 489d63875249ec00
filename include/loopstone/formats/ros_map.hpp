#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "loopstone/base/words.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/grid/grid.hpp"
#include "loopstone/mapping/occupancy.hpp"

namespace loopstone {

/// What a cell of a map says: occupied in percent, or nothing. The values of
/// nav_msgs/OccupancyGrid.
inline constexpr std::int8_t kUnknownCell = -1;
inline constexpr std::int8_t kFreeCell = 0;
inline constexpr std::int8_t kOccupiedCell = 100;
using CellStates = Grid<std::int8_t>;

/// How map_server reads grey values.
enum class MapMode {
  kTrinary,  ///< free, occupied, unknown
  kScale,    ///< percent between the thresholds
  kRaw,      ///< the pixel is the percentage; above 100 unknown
};

constexpr auto words_of(MapMode /*any*/) {
  using enum MapMode;
  return std::array{Word{kTrinary, "trinary"}, Word{kScale, "scale"}, Word{kRaw, "raw"}};
}

/// The YAML file beside a map's picture.
struct RosMapInfo {
  std::string image;  ///< relative to the YAML file's folder unless it starts with '/'
  MapMode mode = MapMode::kTrinary;
  double resolution_m = 0.05;
  Pose2 map_T_corner;   ///< of the lower left corner of the lower left pixel
  bool negate = false;  ///< white is occupied
  double occupied_threshold = 0.65;
  double free_threshold =
      0.196;  ///< (255 - 205) / 255 is 0.19608: 205 stays unknown by this little
};

/// Free below even odds, occupied from 0.65 up, unknown between and where nothing was observed.
[[nodiscard]] CellStates cell_states(const OccupancyMap& map);

/// The picture as map_server writes it: occupied 0, free 254, unknown 205; the top row is the one
/// with the largest y.
[[nodiscard]] Image map_image(const CellStates& cells);
/// origin in full precision, yaw 0.
[[nodiscard]] std::string format_map_yaml(const GridFrame& frame, const std::string& image_name);
/// Writes NAME.yaml and, beside it, NAME.pgm. Either both appear or none.
void write_ros_map(const std::string& yaml_path, const CellStates& cells);

/// Throws DataError with the line.
[[nodiscard]] RosMapInfo parse_map_yaml(std::string_view text,
                                        const std::string& path_for_errors = "map.yaml");
/// Occupancy of every pixel by map_server's rules. A rotated map (yaw other than 0) is drawn anew
/// on a grid along the axes of the map frame, nearest cell; what lies outside the picture is
/// unknown.
[[nodiscard]] CellStates interpret_map(const Image& image, const RosMapInfo& info);
/// Where the picture of a map is. Throws DataError as read_ros_map() does.
[[nodiscard]] std::string ros_map_picture(const std::string& yaml_path);
/// Any map that map_server would read: PGM or PNG. Throws DataError naming the file at fault.
/// \param budget               what the picture may take
/// \param work_bytes_per_cell  what the caller will make of each cell, which is asked for at the
///                             same time
[[nodiscard]] CellStates read_ros_map(const std::string& yaml_path, const MemoryBudget& budget = {},
                                      std::uint64_t work_bytes_per_cell = 0);

}  // namespace loopstone
