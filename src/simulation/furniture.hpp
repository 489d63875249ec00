#pragma once

#include <optional>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/simulation/floor_plan.hpp"
#include "simulation/plan_builder.hpp"

namespace loopstone {

/// Fills a room with furniture, keeping clear what was reserved before.
class Furnisher {
 public:
  /// \param room inner faces of the room's walls, building frame
  Furnisher(PlanBuilder& builder, Rng& rng, const Extent& room)
      : builder_(builder), rng_(rng), room_(room) {}

  /// Keeps a rectangle free of furniture.
  void reserve(const Extent& area) { taken_.push_back(area); }
  /// Keeps a way free between two points: first along x, then along y.
  void reserve_way(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width_m);

  void office(int desks);
  void meeting_room();
  void storage();
  void lounge();
  void open_plan();

 private:
  /// Claims a rectangle; false when it leaves the room or touches something.
  bool claim(const Extent& area, double gap_m);
  /// The pose of something `length_m` long and `depth_m` deep with its back to a random wall, x
  /// along the wall and y into the room, when a free spot was found; `front_m` more stays free
  /// before it.
  std::optional<Pose2> spot_at_wall(double length_m, double depth_m, double front_m);
  std::optional<Pose2> spot_inside(double length_m, double width_m, double gap_m);

  void desk_at_wall();
  void desk(const Pose2& building_T_desk);
  void office_chair(const Pose2& building_T_chair);
  void chair(const Pose2& building_T_chair);
  void box_at_wall(double length_m, double depth_m);
  void round_thing(double radius_m);

  PlanBuilder& builder_;
  Rng& rng_;
  Extent room_;
  std::vector<Extent> taken_{};
};

}  // namespace loopstone
