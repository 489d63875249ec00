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

}  // namespace loopstone::test
