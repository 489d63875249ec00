#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "loopstone/base/words.hpp"
#include "loopstone/geometry/polygon.hpp"
#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// What a line of a plan stands for.
enum class PlanLayer {
  kStructure,  ///< walls, pillars
  kHidden,     ///< wall that furniture hides, drawn through between what was seen of it
  kMovable,    ///< furniture and other things that stand about
};

constexpr auto words_of(PlanLayer /*any*/) {
  using enum PlanLayer;
  return std::array{Word{kStructure, "structure"}, Word{kHidden, "hidden"},
                    Word{kMovable, "movable"}};
}

/// A straight piece of surface, as seen from one side: a wall that is seen from both has two.
/// Standard deviations are about the map, not about the world: of how well the line goes through
/// what was measured, and what scans that saw it agree on.
struct PlanSegment {
  Eigen::Vector2d from{0.0, 0.0};  ///< map frame [m]; who goes to `to` has free space on his left
  Eigen::Vector2d to{0.0, 0.0};
  double sigma_across_m = 0.0;  ///< of the line, at its middle
  double sigma_yaw_rad = 0.0;   ///< of its direction
  double sigma_from_m = 0.0;    ///< of the ends, along the line
  double sigma_to_m = 0.0;
  PlanLayer layer = PlanLayer::kStructure;
  bool squared = false;  ///< its direction is that of an axis, from which it could not be told

  [[nodiscard]] double length_m() const { return (to - from).norm(); }
  [[nodiscard]] Eigen::Vector2d direction() const { return (to - from).normalized(); }
  /// Unit, towards the free side.
  [[nodiscard]] Eigen::Vector2d normal() const {
    const Eigen::Vector2d along = direction();
    return {-along.y(), along.x()};
  }
  [[nodiscard]] Eigen::Vector2d middle() const { return 0.5 * (from + to); }
};

/// What an outline runs along.
enum class PlanSide {
  kWall,    ///< a segment that was seen
  kHidden,  ///< one that was drawn through
  kDoor,    ///< a door or an opening, in the plane of the wall
  kOpen,    ///< nothing: not explored, or a thing that nothing is known behind
};

constexpr auto words_of(PlanSide /*any*/) {
  using enum PlanSide;
  return std::array{Word{kWall, "wall"}, Word{kHidden, "hidden"}, Word{kDoor, "door"},
                    Word{kOpen, "open"}};
}

/// A closed line.
struct PlanOutline {
  Polygon2 polygon{};             ///< map frame [m]
  std::vector<PlanSide> sides{};  ///< of each, from its corner to the next
};

/// An opening between two jambs: a door, or what is wider than one.
struct PlanDoor {
  Eigen::Vector2d from{0.0, 0.0};  ///< the jambs, in the middle of the wall, map frame [m]
  Eigen::Vector2d to{0.0, 0.0};
  double width_m = 0.0;  ///< clear, between the jambs
  double width_sigma_m = 0.0;
  double depth_m = 0.0;  ///< of the wall; 0: only one of its faces was seen
  int room = -1;         ///< places in VectorPlan::rooms; -1: outside, or not explored
  int other_room = -1;

  /// Too wide to be a door.
  [[nodiscard]] bool is_opening() const { return width_m > kWidestDoorM; }
  static constexpr double kWidestDoorM = 1.4;
};

/// A piece of floor that walls and doors go round.
struct PlanRoom {
  PlanOutline outline{};             ///< counter-clockwise; the floor under furniture belongs to it
  std::vector<PlanOutline> holes{};  ///< walls and rooms that it goes round; clockwise
  double area_m2 = 0.0;              ///< without its holes
  double area_sigma_m2 = 0.0;
  /// Of the outline, where no wall was seen: the room goes on unexplored, or ends at a thing [m].
  double open_m = 0.0;
  double perimeter_m = 0.0;  ///< of the outline and of holes
  std::vector<int> doors{};  ///< places in VectorPlan::doors

  double hidden_m = 0.0;  ///< where a wall was drawn through that was not seen [m]

  /// There are walls and doors all around.
  [[nodiscard]] bool is_closed() const { return open_m <= 0.01 * perimeter_m; }
};

/// A direction along which walls run, and at right angles to it.
struct PlanAxis {
  double yaw_rad = 0.0;  ///< [-pi/4, pi/4), map frame
  double sigma_rad = 0.0;
  double share = 0.0;  ///< of the length of all segments, those that run along it
};

/// A map as an architect draws it.
struct VectorPlan {
  std::vector<PlanSegment> segments{};
  std::vector<PlanRoom> rooms{};  ///< largest first
  std::vector<PlanDoor> doors{};
  std::vector<PlanAxis> axes{};  ///< greatest share first; none: walls run anyhow
  bool from_scans = false;       ///< of what the laser measured; else of the cells of the map
};

/// The same plan told in another frame.
[[nodiscard]] VectorPlan operator*(const Pose2& b_T_a, const VectorPlan& in_a);

/// The turn after which the walls run along x and y: about the origin by the negative of the first
/// axis. None: identity.
[[nodiscard]] Pose2 straight_T_map(const VectorPlan& plan);

/// [m], of the segments of a layer.
[[nodiscard]] double length_of(const VectorPlan& plan, PlanLayer layer);

/// Where a room's name stands best: the point farthest from its walls, to within some centimetres.
[[nodiscard]] Eigen::Vector2d label_place(const PlanRoom& room);

/// The smallest box around all segments and rooms: its low and its high corner.
struct PlanBox {
  Eigen::Vector2d low{0.0, 0.0};
  Eigen::Vector2d high{0.0, 0.0};
  [[nodiscard]] Eigen::Vector2d size() const { return high - low; }
};
[[nodiscard]] PlanBox box_of(const VectorPlan& plan);

}  // namespace loopstone
