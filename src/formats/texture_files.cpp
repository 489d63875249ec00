#include "loopstone/formats/texture_files.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <filesystem>

#include "formats/atomic_file.hpp"
#include "formats/map_yaml.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/short_text.hpp"

namespace loopstone {
namespace {

TextureInfo info_of(const MapYaml& yaml) {
  TextureInfo info;
  info.image = yaml.file_name("image");
  if (yaml.find("coverage")) info.coverage = yaml.file_name("coverage");
  info.resolution_m = yaml.resolution_m();
  info.map_T_corner = yaml.pose("origin");
  return info;
}

}  // namespace

GridFrame TextureInfo::frame(int width_px, int height_px) const {
  if (map_T_corner.yaw != 0.0) {
    throw UsageError("the picture '" + with_short_numbers(image) +
                     "' is turned against the map's axes");
  }
  return {.origin = map_T_corner.translation(),
          .resolution = resolution_m,
          .columns = width_px,
          .rows = height_px};
}

std::string format_texture_yaml(const GridFrame& frame, const std::string& image_name,
                                const std::optional<std::string>& coverage_name) {
  std::string text = fmt::format("image: {}\n", image_name);
  text +=
      "# Colours are sRGB. Alpha is 255 where the colour is known, 0 elsewhere. The coverage "
      "picture, grey, is 255 "
      "where\n# the camera saw the floor, 128 where a narrow gap was filled from both sides, 0 "
      "where nothing is "
      "known.\n";
  if (coverage_name) text += fmt::format("coverage: {}\n", *coverage_name);
  text += fmt::format(
      "resolution: {}  # metres per pixel\norigin: [{}, {}, 0]  # of the lower left corner, in the "
      "frame of map.yaml\n",
      frame.resolution, frame.origin.x(), frame.origin.y());
  return text;
}

TextureInfo parse_texture_yaml(std::string_view text, const std::string& path_for_errors) {
  return parse_map_like_yaml(text, path_for_errors, info_of);
}

TextureInfo read_texture_yaml(const std::string& path) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 20;
  TextureInfo info = parse_texture_yaml(read_whole_file(path, kMostBytes), path);
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  const auto from_here = [&](const std::string& name) { return (folder / name).string(); };
  info.image = from_here(info.image);
  if (info.coverage) info.coverage = from_here(*info.coverage);
  return info;
}

std::string format_world_file(const GridFrame& frame) {
  const double half = 0.5 * frame.resolution;
  const double left = frame.origin.x() + half;
  const double top = frame.origin.y() + frame.rows * frame.resolution - half;
  return fmt::format("{}\n0\n0\n{}\n{}\n{}\n", frame.resolution, -frame.resolution, left, top);
}

}  // namespace loopstone
