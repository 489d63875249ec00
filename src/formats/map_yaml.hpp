#pragma once

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "loopstone/base/error.hpp"
#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// The keys of the YAML file beside a map's picture; complaints name file and line.
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
  [[nodiscard]] std::string file_name(const char* key) const {
    const YAML::Node node = require(key);
    if (!node.IsScalar() || node.Scalar().empty()) {
      fail(node, fmt::format("'{}' must name the picture's file", key));
    }
    return node.Scalar();
  }
  [[nodiscard]] double resolution_m() const {
    const YAML::Node node = require("resolution");
    const double value = number(node, "resolution");
    constexpr double kFinest = 1e-4;
    constexpr double kCoarsest = 1000.0;
    if (!(value >= kFinest && value <= kCoarsest)) {
      fail(node,
           fmt::format("'resolution' must be from {} to {:g} [m per pixel]", kFinest, kCoarsest));
    }
    return value;
  }
  [[nodiscard]] Pose2 pose(const char* key) const {
    const YAML::Node node = require(key);
    if (!node.IsSequence() || node.size() != 3) {
      fail(node, fmt::format("'{}' must be [x, y, yaw]", key));
    }
    constexpr double kFarthest = 1e7;  // what is farther lies beyond any grid of the earth (UTM)
    constexpr double kMostTurns = 1e4;
    const Eigen::Vector3d pose(number(node[0], key), number(node[1], key), number(node[2], key));
    if (pose.head<2>().cwiseAbs().maxCoeff() > kFarthest || std::abs(pose.z()) > kMostTurns) {
      fail(node, fmt::format("'{}' must lie within {:g} m of 0, 0", key, kFarthest));
    }
    return {pose.x(), pose.y(), wrap_angle(pose.z())};
  }
  [[noreturn]] void fail(const YAML::Node& node, const std::string& reason) const {
    throw DataError({path_, node.Mark().line + 1}, reason);
  }

 private:
  const YAML::Node& root_;
  const std::string& path_;
};

/// read(MapYaml) of a text. Throws DataError, also when the text is no YAML.
template <typename Read>
auto parse_map_like_yaml(std::string_view text, const std::string& path, const Read& read) {
  // Maps' YAML files are a few lines; nothing sane is nested this deep or this long.
  constexpr std::size_t kMostBytes = std::size_t{1} << 16;
  constexpr int kMostBrackets = 64;
  const auto brackets =
      std::count_if(text.begin(), text.end(), [](char c) { return c == '[' || c == '{'; });
  if (text.size() > kMostBytes || brackets > kMostBrackets) {
    throw DataError({path}, "is no map's YAML file: it is too long or too deeply nested");
  }
  try {
    const YAML::Node root = YAML::Load(std::string(text));
    if (!root.IsMap()) {
      throw DataError({path}, "is no map's YAML file; expected lines such as 'image: map.pgm'");
    }
    return read(MapYaml(root, path));
  } catch (const YAML::Exception& error) {
    throw DataError({path, error.mark.line + 1},
                    "is no valid YAML from here on; a map's lines read 'resolution: 0.05'");
  }
}

}  // namespace loopstone
