#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/ros_map.hpp"

namespace loopstone {
namespace {

/// Maps' YAML files are a few lines; nothing sane is nested this deep or this long.
constexpr std::size_t kMostBytes = std::size_t{1} << 16;
constexpr int kMostBrackets = 64;

class MapYaml {
 public:
  MapYaml(const YAML::Node& root, const std::string& path) : root_(root), path_(path) {}

  [[nodiscard]] YAML::Node require(const char* key) const {
    const YAML::Node node = root_[key];
    if (!node) throw DataError({path_}, fmt::format("has no key '{}', which a map needs", key));
    return node;
  }
  [[nodiscard]] std::optional<YAML::Node> find(const char* key) const {
    const YAML::Node node = root_[key];
    return node ? std::optional<YAML::Node>(node) : std::nullopt;
  }
  [[nodiscard]] double number(const YAML::Node& node, const char* key) const {
    double value = 0.0;
    if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !std::isfinite(value)) {
      fail(node, fmt::format("'{}' must be a finite number", key));
    }
    return value;
  }
  [[noreturn]] void fail(const YAML::Node& node, const std::string& reason) const {
    throw DataError({path_, node.Mark().line + 1}, reason);
  }

 private:
  const YAML::Node& root_;
  const std::string& path_;
};

MapMode parse_mode(const MapYaml& yaml, const YAML::Node& node) {
  const std::string word = node.IsScalar() ? node.Scalar() : std::string();
  if (word == "trinary") return MapMode::kTrinary;
  if (word == "scale") return MapMode::kScale;
  if (word == "raw") return MapMode::kRaw;
  yaml.fail(node, "'mode' must be trinary, scale or raw");
}

/// 0 and 1 in most files, true and false in some.
bool parse_negate(const MapYaml& yaml, const YAML::Node& node) {
  bool word = false;
  if (node.IsScalar() && YAML::convert<bool>::decode(node, word)) return word;
  return yaml.number(node, "negate") != 0.0;
}

Pose2 parse_origin(const MapYaml& yaml, const YAML::Node& node) {
  if (!node.IsSequence() || node.size() != 3) yaml.fail(node, "'origin' must be [x, y, yaw]");
  return {yaml.number(node[0], "origin"), yaml.number(node[1], "origin"),
          wrap_angle(yaml.number(node[2], "origin"))};
}

double parse_threshold(const MapYaml& yaml, const char* key) {
  const YAML::Node node = yaml.require(key);
  const double value = yaml.number(node, key);
  if (value < 0.0 || value > 1.0) yaml.fail(node, fmt::format("'{}' must lie in [0, 1]", key));
  return value;
}

RosMapInfo info_of(const MapYaml& yaml) {
  RosMapInfo info;
  const YAML::Node image = yaml.require("image");
  if (!image.IsScalar() || image.Scalar().empty())
    yaml.fail(image, "'image' must name the picture's file");
  info.image = image.Scalar();
  if (const auto mode = yaml.find("mode")) info.mode = parse_mode(yaml, *mode);
  const YAML::Node resolution = yaml.require("resolution");
  info.resolution_m = yaml.number(resolution, "resolution");
  if (!(info.resolution_m > 0.0))
    yaml.fail(resolution, "'resolution' must be more than 0 [m per pixel]");
  info.map_T_corner = parse_origin(yaml, yaml.require("origin"));
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
  const auto brackets =
      std::count_if(text.begin(), text.end(), [](char c) { return c == '[' || c == '{'; });
  if (text.size() > kMostBytes || brackets > kMostBrackets) {
    throw DataError({path_for_errors},
                    "is no map's YAML file: it is too long or too deeply nested");
  }
  try {
    const YAML::Node root = YAML::Load(std::string(text));
    if (!root.IsMap()) {
      throw DataError({path_for_errors},
                      "is no map's YAML file; expected lines such as 'image: map.pgm'");
    }
    return info_of(MapYaml(root, path_for_errors));
  } catch (const YAML::Exception& error) {
    throw DataError({path_for_errors, error.mark.line + 1}, "is no valid YAML: " + error.msg);
  }
}

}  // namespace loopstone
