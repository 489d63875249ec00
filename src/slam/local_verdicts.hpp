#pragma once

#include <string>
#include <vector>

#include "loopstone/slam/map_result.hpp"
#include "loopstone/slam/map_verdict.hpp"

// What the worst part of a map says, where shares of the whole map hide it.

namespace loopstone {

/// Whether what is off by no more than that is right.
[[nodiscard]] bool is_right(const PossibleError& error);

/// Whether some place may be off by more than what a right map is, by what nothing ties or what is
/// as long as odometry says.
[[nodiscard]] bool may_be_wrong(const MapResult& result);

/// Two visits that contradict each other over some metres of wall: where, when and by how much.
[[nodiscard]] QualityMeasure judge_contradictions(const MapResult& result);
/// The part of the path that hangs on nothing or on one closure: by how much it could be off.
[[nodiscard]] QualityMeasure judge_loose_parts(const MapResult& result);
/// Travel with a direction that the laser leaves open: which stretch, and by how much the map may
/// be too long or too short there.
[[nodiscard]] QualityMeasure judge_open_stretches(const MapResult& result);

/// Times during which odometry and the laser contradicted each other for a while, in no way that an
/// odometer fails in: either may have been wrong. In plain words.
[[nodiscard]] std::vector<std::string> unexplained_contradictions(const MapResult& result);

/// The worst of each, one by one, for the user.
[[nodiscard]] std::vector<std::string> local_warnings(const MapResult& result);

}  // namespace loopstone
