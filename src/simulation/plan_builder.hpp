#pragma once

#include <Eigen/Core>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/simulation/world.hpp"

namespace loopstone {

/// A gap in a wall, by its middle along the wall.
struct Opening {
  double at_m = 0.0;
  double width_m = 0.0;
};

/// An opening in a building's outer wall, to which a passage can be joined; map frame.
struct Gate {
  Eigen::Vector2d left;  ///< seen from within, looking out
  Eigen::Vector2d right;
};

/// Adds things, given in a building's own frame, to a world.
class PlanBuilder {
 public:
  PlanBuilder(World& world, const Pose2& map_T_building)
      : world_(world), map_T_building_(map_T_building) {}

  /// A straight wall around the line from a to b, but for the openings.
  void wall(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double thickness_m,
            std::vector<Opening> openings = {});
  /// A closed rectangle of walls that stand outside [0, width] x [0, depth]. Its floor counts.
  void shell(double width_m, double depth_m, double thickness_m);
  void box(const Pose2& building_T_box, double length_m, double width_m);
  void circle(const Eigen::Vector2d& centre, double radius_m);
  void keep_out(const Pose2& building_T_box, double length_m, double width_m);
  void place(const Eigen::Vector2d& point);
  void return_to(const Eigen::Vector2d& point);
  void start(const Pose2& building_T_start);

  [[nodiscard]] Eigen::Vector2d in_map(const Eigen::Vector2d& point) const {
    return map_T_building_ * point;
  }
  [[nodiscard]] World& world() { return world_; }

 private:
  World& world_;
  Pose2 map_T_building_;
};

}  // namespace loopstone
