#pragma once

#include <vector>

#include "loopstone/slam/front_end.hpp"
#include "support/segment_world.hpp"

namespace loopstone::test {

/// A finished submap of a place as seen from some poses; its frame is the first of them.
inline FinishedSubmap submap_seen_from(const Walls& place, const std::vector<Pose2>& world_T_robot,
                                       std::size_t first_key, const Scanner& scanner = {}) {
  Submap submap({});
  BeamTable beams;
  for (const auto& pose : world_T_robot) {
    const auto scan = scan_from(place, pose, {}, scanner);
    const auto surfaces = surface_points(scan, {}, Tangent2::Zero(), {}, beams);
    submap.insert(surfaces, scan, {}, world_T_robot.front().inverse() * pose, beams);
  }
  return {submap.freeze(), first_key, first_key};
}

/// A submap in which nothing was seen.
inline FinishedSubmap empty_submap(std::size_t first_key) {
  return {Submap({}).freeze(), first_key, first_key};
}

/// A room and a corridor with a thin wall between them, and a door in it: the submap of each.
struct BothSides {
  FinishedSubmap room;
  FinishedSubmap corridor;
  Pose2 room_T_corridor{};
};
inline BothSides both_sides_of_a_thin_wall() {
  const Walls walls{
      {{0.0, 0.0}, {6.0, 0.0}},  {{6.0, 0.0}, {6.0, 4.0}},   {{0.0, 4.0}, {0.0, 0.0}},
      {{0.0, 4.0}, {2.5, 4.0}},  {{3.5, 4.0}, {6.0, 4.0}},   {{2.5, 4.0}, {2.5, 4.1}},
      {{3.5, 4.1}, {3.5, 4.0}},  {{-2.0, 4.1}, {2.5, 4.1}},  {{3.5, 4.1}, {8.0, 4.1}},
      {{-2.0, 6.0}, {8.0, 6.0}}, {{-2.0, 4.1}, {-2.0, 6.0}}, {{8.0, 4.1}, {8.0, 6.0}}};
  const std::vector<Pose2> within{{3.0, 2.5, 0.0}, {2.4, 1.6, 1.0}, {3.6, 1.8, 2.0}};
  const std::vector<Pose2> outside{{3.0, 4.9, -1.5}, {2.2, 5.0, -1.0}, {3.8, 5.0, -2.0}};
  return {submap_seen_from(walls, within, 0), submap_seen_from(walls, outside, 0),
          within.front().inverse() * outside.front()};
}

}  // namespace loopstone::test
