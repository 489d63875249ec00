#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <string>

#include "formats/map_yaml.hpp"
#include "loopstone/formats/ros_map.hpp"

namespace loopstone {
namespace {

MapMode parse_mode(const MapYaml& yaml, const YAML::Node& node) {
  const auto mode = find_word<MapMode>(node.IsScalar() ? node.Scalar() : std::string());
  if (mode) return *mode;
  yaml.fail(node, "'mode' must be trinary, scale or raw");
}

/// 0 and 1 in most files, true and false in some.
bool parse_negate(const MapYaml& yaml, const YAML::Node& node) {
  bool word = false;
  if (node.IsScalar() && YAML::convert<bool>::decode(node, word)) return word;
  return yaml.number(node, "negate") != 0.0;
}

double parse_threshold(const MapYaml& yaml, const char* key) {
  const YAML::Node node = yaml.require(key);
  const double value = yaml.number(node, key);
  if (value < 0.0 || value > 1.0) yaml.fail(node, fmt::format("'{}' must lie in [0, 1]", key));
  return value;
}

RosMapInfo info_of(const MapYaml& yaml) {
  RosMapInfo info;
  info.image = yaml.file_name("image");
  if (const auto mode = yaml.find("mode")) info.mode = parse_mode(yaml, *mode);
  info.resolution_m = yaml.resolution_m();
  info.map_T_corner = yaml.pose("origin");
  if (const auto negate = yaml.find("negate")) info.negate = parse_negate(yaml, *negate);
  info.occupied_threshold = parse_threshold(yaml, "occupied_thresh");
  info.free_threshold = parse_threshold(yaml, "free_thresh");
  if (info.mode != MapMode::kRaw && info.free_threshold >= info.occupied_threshold) {
    yaml.fail(yaml.require("free_thresh"), "'free_thresh' must be less than 'occupied_thresh'");
  }
  return info;
}

}  // namespace

RosMapInfo parse_map_yaml(std::string_view text, const std::string& path_for_errors) {
  return parse_map_like_yaml(text, path_for_errors, info_of);
}

}  // namespace loopstone
