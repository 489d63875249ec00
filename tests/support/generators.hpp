#pragma once

#include <rapidcheck.h>

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/geometry/pose3.hpp"

// Generators for laws: each covers the cases where formulas change branch, and the ordinary ones
// between.
namespace loopstone::test {

/// In [low, high], both ends included; shrinks towards low.
[[nodiscard]] inline rc::Gen<double> between(double low, double high) {
  constexpr int kSteps = 1 << 30;
  return rc::gen::map(rc::gen::inRange(0, kSteps + 1),
                      [=](int step) { return low + (high - low) * step / kSteps; });
}

/// Angles in (-pi, pi]: zero, tiny, close to the switches of series expansions, pi, almost +-pi,
/// and any.
[[nodiscard]] inline rc::Gen<double> any_angle() {
  return rc::gen::oneOf(rc::gen::element(0.0, 1e-12, -1e-9, 1e-5, -9.9e-5, 1.01e-4, 1e-3, -1.1e-3,
                                         kPi, kPi - 1e-9, -kPi + 1e-9, 0.5 * kPi, -0.5 * kPi),
                        between(-3.14159, 3.14159));
}

/// Poses of the plane: {identity, tiny, pi, random} within 10 m.
[[nodiscard]] inline rc::Gen<Pose2> any_pose2() {
  const auto shift = rc::gen::oneOf(rc::gen::element(0.0, 1e-9, -1e-6), between(-10.0, 10.0));
  return rc::gen::apply(
      [](double x, double y, double yaw) {
        return Pose2{x, y, yaw};
      },
      shift, shift, any_angle());
}

/// Tangents of the plane whose exp stays on the branch of log.
[[nodiscard]] inline rc::Gen<Tangent2> any_tangent2() {
  const auto shift = rc::gen::oneOf(rc::gen::element(0.0, 1e-9, -1e-6), between(-10.0, 10.0));
  return rc::gen::apply([](double x, double y, double yaw) { return Tangent2(x, y, yaw); }, shift,
                        shift, any_angle());
}

/// Tangents of space; the rotation vector's length is within [0, pi].
[[nodiscard]] inline rc::Gen<Tangent3> any_tangent3() {
  const auto axis = between(-1.0, 1.0);
  return rc::gen::apply(
      [](double x, double y, double z, double ax, double ay, double az, double angle) {
        Eigen::Vector3d direction(ax, ay, az);
        if (direction.norm() < 1e-3) direction = Eigen::Vector3d::UnitX();
        Tangent3 twist;
        twist << x, y, z, angle * direction.normalized();
        return twist;
      },
      between(-10.0, 10.0), between(-10.0, 10.0), between(-10.0, 10.0), axis, axis, axis,
      any_angle());
}

}  // namespace loopstone::test
