#include "loopstone/formats/filter_mask_file.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>

#include "formats/toml_values.hpp"

namespace loopstone {

namespace {

/// The servers of a mask: who shows it, and who says how it is meant. A number without a point
/// would be no double there.
std::string servers_of(const std::string& name, const FilterMask& mask) {
  return fmt::format(R"({0}_filter_mask_server:
  ros__parameters:
    yaml_filename: "{0}_mask.yaml"  # with its path
    topic_name: "{0}_filter_mask"
    frame_id: "map"
{0}_costmap_filter_info_server:
  ros__parameters:
    type: {1}
    filter_info_topic: "{0}_costmap_filter_info"
    mask_topic: "{0}_filter_mask"
    base: {2}
    multiplier: {3}
)",
                     name, static_cast<int>(mask.type), toml_number(mask.base),
                     toml_number(mask.multiplier));
}

}  // namespace

Image mask_image(const FilterMask& mask) {
  const GridFrame& frame = mask.values.frame();
  Image image = make_image(frame.columns, frame.rows, 1);
  std::size_t i = 0;
  for (int row = frame.rows - 1; row >= 0; --row) {
    for (int column = 0; column < frame.columns; ++column)
      image.bytes[i++] = static_cast<std::uint8_t>(mask.values[{column, row}]);
  }
  return image;
}

std::string format_mask_yaml(const GridFrame& frame, const std::string& image_name) {
  return fmt::format(
      "image: {}\nmode: raw\nresolution: {}\norigin: [{}, {}, 0]\nnegate: 0\noccupied_thresh: "
      "0.65\nfree_thresh: 0.196\n",
      image_name, frame.resolution, frame.origin.x(), frame.origin.y());
}

std::string format_nav2_filters(const FilterMask* keep_out, const FilterMask* speed) {
  std::string text =
      "# For the parameters of nav2: both servers of each mask are to be started with the others "
      "and\n# named to the lifecycle manager.\n";
  if (keep_out != nullptr) text += servers_of("keepout", *keep_out);
  if (speed != nullptr) text += servers_of("speed", *speed);
  const char* const filters = keep_out == nullptr ? "\"speed_filter\""
                              : speed == nullptr  ? "\"keepout_filter\""
                                                  : "\"keepout_filter\", \"speed_filter\"";
  text += fmt::format(
      "global_costmap:\n  global_costmap:\n    ros__parameters:\n      filters: [{}]\n", filters);
  if (keep_out != nullptr) {
    text += R"(      keepout_filter:
        plugin: "nav2_costmap_2d::KeepoutFilter"
        enabled: true
        filter_info_topic: "/keepout_costmap_filter_info"
)";
  }
  if (speed != nullptr) {
    text += R"(      speed_filter:
        plugin: "nav2_costmap_2d::SpeedFilter"
        enabled: true
        filter_info_topic: "/speed_costmap_filter_info"
        speed_limit_topic: "/speed_limit"
)";
  }
  return text;
}

}  // namespace loopstone
