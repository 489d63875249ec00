#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/grid/grid_frame.hpp"

namespace loopstone {

/// The YAML file beside the picture of the floor. Its keys are those of map.yaml where they mean
/// the same.
struct TextureInfo {
  std::string image;  ///< relative to the YAML file's folder unless it starts with '/'
  /// Grey picture of the same size: 255 seen, 128 filled, 0 unknown.
  std::optional<std::string> coverage{};
  double resolution_m = 0.01;
  Pose2 map_T_corner;  ///< of the lower left corner of the lower left pixel

  /// The pixels as cells along the axes of the map frame. Throws UsageError when the picture is
  /// turned.
  [[nodiscard]] GridFrame frame(int width_px, int height_px) const;
};

/// origin in full precision, yaw 0.
[[nodiscard]] std::string format_texture_yaml(const GridFrame& frame, const std::string& image_name,
                                              const std::optional<std::string>& coverage_name = {});
/// Throws DataError with the line.
[[nodiscard]] TextureInfo parse_texture_yaml(std::string_view text,
                                             const std::string& path_for_errors = "texture.yaml");
/// The same from a file; the names of the pictures are made relative to the folder one is in.
[[nodiscard]] TextureInfo read_texture_yaml(const std::string& path);

/// The world file of a picture (texture.pgw beside texture.png), by which GIS programs place it:
/// the lines A D B E C F of x = A column + B row + C, y = D column + E row + F [m], for the centres
/// of the pixels counted from the upper left.
[[nodiscard]] std::string format_world_file(const GridFrame& frame);

}  // namespace loopstone
