#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/grid/grid.hpp"
#include "loopstone/simulation/floor_pattern.hpp"
#include "loopstone/simulation/floor_plan.hpp"

namespace loopstone {

/// A retroreflector, which a laser sees brightly: a flat strip on a wall, or a round post.
struct Reflector {
  int id = 0;
  Eigen::Vector2d centre{0.0, 0.0};  ///< of the strip's surface, or of the post, map frame [m]
  Eigen::Vector2d normal{0.0, 0.0};  ///< out of the wall, of a strip; unit length
  double width_m = 0.0;              ///< of a strip
  double radius_m = 0.0;             ///< of a post; 0: a strip
};

/// A place in which a robot can drive and measure.
struct World {
  std::string name;
  std::uint64_t seed = 0;
  FloorPlan plan{};             ///< what a laser sees, map frame
  std::vector<Box> keep_out{};  ///< a laser passes, a robot does not: table tops, racks
  Pose2 map_T_start{};
  std::vector<Eigen::Vector2d> places{};   ///< worth a visit; the first ones matter most
  std::vector<Eigen::Vector2d> returns{};  ///< passed in this order after the visit, to close loops
  std::vector<Reflector> reflectors{};     ///< with any, scans have intensities
  double floor_area_m2 = 0.0;              ///< gross, inside the outer walls
  std::optional<Grid<std::int8_t>>
      given_map{};                              ///< the map that the world was made from, if it was
  std::shared_ptr<const FloorPattern> floor{};  ///< colour of the floor; without: "mixed"
};

/// The names that make_world knows.
[[nodiscard]] const std::vector<std::string_view>& world_names();

/// A built-in world. Different seeds differ in walls, doors and furniture, not in kind.
///   office about 1,000 m2: two corridors, cross corridors, rooms with doors, furniture; loops of
///   60 to 130 m
///   campus     about 10,000 m2: six buildings joined by passages; loops of several hundred metres
///   corridor   100 m straight between two small rooms, nothing to hold on to on the way
///   rooms      rows of rooms that are all alike
///   warehouse  aisles between racks
///   loops      a ring of long, nearly bare corridors, 100 to 400 m round, closed at one place
///   wings      two floors of four wings, all alike, joined by one passage
///   aisles     a warehouse whose aisles are equal to the last box
///   hall       100 m x 80 m, a few columns: larger than a laser's reach
///   outdoors   between buildings, with trees and cars; no wall around it
/// Throws UsageError for another name.
[[nodiscard]] World make_world(std::string_view name, std::uint64_t seed);

/// A world from a map: occupancy of the cells in percent, -1 where unknown, as
/// nav_msgs/OccupancyGrid has it. Cells that are unknown or occupied by 65 % or more are solid. The
/// start and the places are chosen in its largest free region.
/// Throws UsageError when there is no room for a robot of that radius.
[[nodiscard]] World make_world(const Grid<std::int8_t>& map, const std::string& name,
                               double robot_radius_m);

/// The map that a perfect robot would draw: 100 where a solid covers a cell's centre or comes
/// within half a cell of it, 0 where the rest can be reached from the start, -1 elsewhere. A given
/// map is returned as it is.
[[nodiscard]] Grid<std::int8_t> true_map(const World& world, double resolution_m = 0.05);

}  // namespace loopstone
