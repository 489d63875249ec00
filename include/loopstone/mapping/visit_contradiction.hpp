#pragma once

#include <Eigen/Core>

#include "loopstone/base/stamp.hpp"

namespace loopstone {

/// A region in which two visits draw the same surroundings differently: beams of one pass through
/// walls of the other and end far behind them, or the same wall lies far apart in both. What moved
/// between the visits (a door, a chair, a person) is a region of less than a few metres of wall.
struct VisitContradiction {
  Eigen::Vector2d low = Eigen::Vector2d::Zero();  ///< corners of its box, map frame [m]
  Eigen::Vector2d high = Eigen::Vector2d::Zero();
  Stamp first_from{};  ///< the earlier visit
  Stamp first_to{};
  Stamp second_from{};  ///< the later one
  Stamp second_to{};
  double wall_m = 0.0;   ///< walls of one visit that the other contradicts
  double share = 0.0;    ///< [0, 1], of the walls that both visits have something to say about
  double apart_m = 0.0;  ///< how far apart or behind the walls, median

  [[nodiscard]] Eigen::Vector2d centre() const { return 0.5 * (low + high); }
};

/// Two visits, some way of travel apart, that draw the same walls in the same place, walls that
/// hold both directions: as good as a loop closure between them.
struct VisitTie {
  Stamp first{};   ///< in the middle of the earlier visit
  Stamp second{};  ///< in the middle of the later one
};

}  // namespace loopstone
