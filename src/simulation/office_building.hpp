#pragma once

#include <vector>

#include "loopstone/base/rng.hpp"
#include "simulation/plan_builder.hpp"

namespace loopstone {

/// An office building: two long corridors (along x) with rooms on both sides, joined by crossings
/// (along y).
///
///      +--------------------------------------+
///      |    |     | north rooms   |      |    |
///      |  north corridor                      |  <- gates at both ends
///      |-----+  +---------+  +---------+  +---|
///      |     |  |  block  |  | block   |  |   |
///      |-----+  +---------+  +---------+  +---|
///      |  south corridor                      |
///      |   |   | south rooms |   |            |
///      +--------------------------------------+
struct OfficeShape {
  double width_m = 40.0;
  double south_m = 5.2;  ///< depth of the southern rooms
  double corridor_m = 2.1;
  double middle_m = 11.0;
  double north_m = 5.4;
  double crossing_m = 1.9;                           ///< width of a crossing
  std::vector<double> crossings_m{6.5, 21.0, 34.0};  ///< x of their middles
  int open_block =
      1;  ///< block (0: west of the first crossing) that is one open-plan office; -1: none
  double visited_share = 1.0;  ///< of the rooms
};

/// Gaps in the outer wall to build; each gives a Gate.
struct OfficeGates {
  bool west_south = false;
  bool east_south = false;
  bool west_north = false;
  bool east_north = false;
  bool south = false;  ///< the middle crossing goes on through the southern rooms
  bool north = false;
};

/// The gates that were asked for, where they came to be.
struct OfficeExits {
  Gate west_south, east_south, west_north, east_north, south, north;
};

OfficeExits add_office(PlanBuilder& builder, const OfficeShape& shape, const OfficeGates& gates,
                       Rng& rng);

/// Depth of the whole building (along y).
[[nodiscard]] double depth_of(const OfficeShape& shape);

/// A passage between two gates, with a few pilasters on its walls.
void add_passage(World& world, const Gate& from, const Gate& to, Rng& rng);

}  // namespace loopstone
