#pragma once

#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/sensor/scan_points.hpp"

namespace loopstone {

/// When a building has two directions, at right angles, along which its walls run.
struct WallAxesNumbers {
  int bins_per_degree = 2;
  double peak_half_deg = 1.5;
  double facing_half_deg = 7.5;
  double fine_half_deg = 4.0;
  double elsewhere_deg = 15.0;
  double least_share = 0.35;
  double rival_share = 0.6;
};
inline constexpr WallAxesNumbers kWallAxes{};

template <typename Visitor>
void visit_numbers(const WallAxesNumbers& n, Visitor&& visit) {
  visit("bins_per_degree", n.bins_per_degree,
        "chosen: of the directions of surfaces: finer than a normal is known");
  visit("peak_half_deg", n.peak_half_deg,
        "chosen: normals of a wall err by a degree or so: its directions are one peak");
  visit("facing_half_deg", n.facing_half_deg,
        "chosen: a surface turned from an axis by no more runs along it");
  visit("fine_half_deg", n.fine_half_deg,
        "chosen: of those, so near to the axis that slanted things do not pull at it");
  visit("elsewhere_deg", n.elsewhere_deg,
        "derived: two windows of facing_half_deg beside each other share nothing");
  visit("least_share", n.least_share,
        "derived: twice what surfaces that face everywhere alike would show (15 of 90 degrees), "
        "and a little");
  visit("rival_share", n.rival_share,
        "chosen: another pair of directions with this share of the first one's surfaces is as "
        "good: a building with two wings turned to one another");
}

/// The directions of a map's walls.
struct WallAxes {
  /// Of one of the two axes, the one nearest to x: [-pi/4, pi/4). Turned by its negative, the walls
  /// lie along x and y.
  double map_yaw_rad = 0.0;
  double share = 0.0;       ///< [0, 1], of the surfaces, by length: those that face along the axes
  double next_share = 0.0;  ///< the same of the best other pair of axes
  [[nodiscard]] bool are_clear() const {
    return share >= kWallAxes.least_share && next_share <= kWallAxes.rival_share * share;
  }
};

/// By where surfaces face: the direction, of a quarter turn, that most of them share, as the mean
/// of those near to it. Surfaces are thinned to an even spacing, so each counts by its length and
/// by how often it was seen.
/// \param map_T_keys  of key scans
/// \param surfaces    of each, its own frame; whose normals were guessed do not count
/// Cost: O(surfaces). Deterministic.
[[nodiscard]] WallAxes wall_axes(std::span<const Pose2> map_T_keys,
                                 std::span<const std::vector<SurfacePoint>> surfaces);

}  // namespace loopstone
