#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// A piece of the plane: its corners in order, either way round; the last one is joined to the
/// first.
struct Polygon2 {
  std::vector<Eigen::Vector2d> corners{};  ///< [m]
  friend bool operator==(const Polygon2&, const Polygon2&) = default;
};

/// The four corners of the box from (min_x, min_y) to (max_x, max_y).
[[nodiscard]] Polygon2 box_polygon(const Eigen::Vector2d& low, const Eigen::Vector2d& high);

/// Why this encloses nothing that one can speak of, in words that follow "must ": fewer than three
/// corners, no area, sides that cross. Nothing: it is sound. Cost: the square of the corners.
[[nodiscard]] std::optional<std::string> fault_of(const Polygon2& polygon);

/// Whether a point lies inside; on a side, either. Even-odd rule.
[[nodiscard]] bool contains(const Polygon2& polygon, const Eigen::Vector2d& point);

/// Of a sound polygon: counted as if it were a plate.
[[nodiscard]] Eigen::Vector2d centroid_of(const Polygon2& polygon);
/// [m^2], never negative.
[[nodiscard]] double area_of(const Polygon2& polygon);

/// The same piece told in another frame, or moved.
[[nodiscard]] Polygon2 operator*(const Pose2& b_T_a, const Polygon2& in_a);

}  // namespace loopstone
