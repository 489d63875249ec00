#pragma once

#include <Eigen/Core>
#include <vector>

#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// A straight surface, seen from both sides.
struct Segment {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
};

/// A round column, a table leg.
struct Circle {
  Eigen::Vector2d centre;
  double radius_m = 0.0;
};

/// A solid rectangle: a piece of wall, a cabinet. Its x axis runs along the length.
struct Box {
  Pose2 map_T_box;  ///< of its centre
  double length_m = 0.0;
  double width_m = 0.0;
  bool is_wall = false;  ///< else a thing that stands before one
};

/// What stands in a building at the height of the laser. Solids may overlap; a ray sees the outline
/// of their union.
struct FloorPlan {
  std::vector<Box> boxes{};
  std::vector<Circle> circles{};
  std::vector<Segment>
      surfaces{};  ///< without an inside: the borders of a grid map's occupied cells
};

/// An axis-aligned rectangle.
struct Extent {
  Eigen::Vector2d low{0.0, 0.0};
  Eigen::Vector2d high{0.0, 0.0};
};

/// The four sides, counter-clockwise.
[[nodiscard]] std::vector<Segment> outline(const Box& box);

/// All flat surfaces of a plan: the outlines of its boxes, then its bare surfaces.
[[nodiscard]] std::vector<Segment> flat_surfaces(const FloorPlan& plan);

/// The smallest rectangle around everything. Both corners are zero for an empty plan.
[[nodiscard]] Extent extent_of(const FloorPlan& plan);

/// Whether a point lies in or on a solid.
[[nodiscard]] bool is_inside(const Box& box, const Eigen::Vector2d& point);
[[nodiscard]] bool is_inside(const Circle& circle, const Eigen::Vector2d& point);

/// Distance from a point to a surface [m]; 0 on it.
[[nodiscard]] double distance_to(const Segment& segment, const Eigen::Vector2d& point);
/// Distance to the rim, also from within.
[[nodiscard]] double distance_to(const Circle& circle, const Eigen::Vector2d& point);

}  // namespace loopstone
