#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>

#include "mapping/scan_beams.hpp"

// A beam that grazes a wall runs along it, within a cell of its face, for a metre and more before
// it ends. Those cells are the wall's, and a pose that is a little off puts more of the way into
// them: far beams that graze would wear away what near ones drew.

namespace loopstone {

/// The direction of the line that three neighbouring returns lie on; none when one of them lies off
/// it, or before or behind the others.
[[nodiscard]] inline std::optional<Eigen::Vector2d> line_through(const Beam& a, const Beam& b,
                                                                 const Beam& c) {
  constexpr double kOffM = 0.03;
  constexpr double kUneven = 3.0;
  if (!a.hit || !b.hit || !c.hit) return {};
  const Eigen::Vector2d first = b.end - a.end;
  const Eigen::Vector2d second = c.end - b.end;
  const double before = first.squaredNorm();
  const double after = second.squaredNorm();
  if (before > kUneven * kUneven * after || after > kUneven * kUneven * before) return {};
  const Eigen::Vector2d along = c.end - a.end;
  const double length = along.norm();
  if (!(length > 0.0) || std::abs(along.x() * first.y() - along.y() * first.x()) > kOffM * length)
    return {};
  return Eigen::Vector2d(along / length);
}

/// Sine of the angle between a beam and the surface that it ends on; 1 where its neighbours don't
/// tell. Cost: O(1).
[[nodiscard]] inline double incidence_sine(std::span<const Beam> beams, std::size_t i) {
  const Eigen::Vector2d way = beams[i].end - beams[i].start;
  const double length = way.norm();
  if (!beams[i].hit || !(length > 0.0)) return 1.0;
  std::optional<double> steepest;
  for (std::size_t first = i < 2 ? 0 : i - 2; first <= i && first + 2 < beams.size(); ++first) {
    const auto line = line_through(beams[first], beams[first + 1], beams[first + 2]);
    if (!line) continue;
    const double sine = std::abs(way.x() * line->y() - way.y() * line->x()) / length;
    steepest = std::max(steepest.value_or(0.0), sine);
  }
  return steepest.value_or(1.0);
}

/// Up to where a beam says that its way is free: not where it is nearer to the surface that it
/// grazes than `near_m`.
[[nodiscard]] inline Eigen::Vector2d free_end(std::span<const Beam> beams, std::size_t i,
                                              double near_m) {
  constexpr double kLeastSine = 0.01;
  const Beam& beam = beams[i];
  const double sine = std::clamp(incidence_sine(beams, i), kLeastSine, 1.0);
  const double length = (beam.end - beam.start).norm();
  const double kept_m = length - near_m * (1.0 / sine - 1.0);
  if (kept_m >= length) return beam.end;
  return beam.start + std::max(0.0, kept_m / length) * (beam.end - beam.start);
}

}  // namespace loopstone
