#pragma once

#include <Eigen/Core>
#include <span>

#include "loopstone/geometry/rigid_alignment.hpp"

namespace loopstone {

/// A point and the line that it belongs to.
struct PointOnLine {
  Eigen::Vector2d point;   ///< source frame
  Eigen::Vector2d anchor;  ///< any point of the line, target frame
  Eigen::Vector2d normal;  ///< of the line, unit, target frame
  double weight = 1.0;     ///< not negative
};

/// The motion that minimises sum_i w_i (n_i^T (R p_i + t - q_i))^2, over all motions of the plane
/// at once. With (cos, sin) as two unknowns of unit length the problem is quadratic; its Lagrange
/// multiplier is the greatest root of a quartic. `unique` is false where the lines leave a motion
/// open: when they are parallel, or tangents of one circle.
/// Cost: O(points). Source: Censi 2008, "An ICP variant using a point-to-line metric", appendix I.
[[nodiscard]] RigidAlignment<2> align_to_lines(std::span<const PointOnLine> pairs);

}  // namespace loopstone
