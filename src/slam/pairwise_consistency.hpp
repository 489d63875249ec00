#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/slam/loop_closure.hpp"

namespace loopstone {

/// The map as it is, for judging what a closure would do to it.
struct MapSoFar {
  std::span<const Pose2> poses;         ///< of the graph's nodes
  std::span<const double> travelled_m;  ///< along the path, at each node
};

/// Whether a closure says what the map says already, in the directions that it holds: it may stand
/// on its own.
[[nodiscard]] bool bends_nothing(const LoopClosure& closure, const MapSoFar& map);

/// Whether two closures between the same stretches of the path ask for the same correction: the
/// loop of both and of the path between their ends closes, and would not without the correction.
/// Two false closures seldom err alike, unless they are of the same scans: closures of submaps that
/// are neighbours on both sides count as two only where each overlaps by three quarters and agrees
/// to 85 %.
/// Source: Mangelson et al. 2018, "Pairwise consistent measurement set maximization for robust
/// multi-robot map merging".
[[nodiscard]] bool are_consistent(const LoopClosure& a, const LoopClosure& b, const MapSoFar& map);

/// Settles which of the closures that wait may stand: those that bend nothing, and those with which
/// another one, standing or waiting, is consistent. Returns their places among the closures.
std::vector<std::size_t> accept_consistent(std::vector<LoopClosure>& closures, const MapSoFar& map);

}  // namespace loopstone
