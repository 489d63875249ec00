#pragma once

#include <cstddef>
#include <functional>
#include <optional>

#include "loopstone/mapping/submap.hpp"
#include "slam/edit_state.hpp"
#include "slam/loop_verification.hpp"

namespace loopstone {

/// Nodes from one to another, both included.
struct NodeRange {
  std::size_t first = 0;
  std::size_t last = 0;
};

/// Those around a node along the path, so far to each side, as far as the laser held the path.
[[nodiscard]] NodeRange nodes_around(std::size_t node, double reach_m, const EditedPath& path);

/// What key scans saw as a submap of its own, in the frame of one of them; by the path that the
/// front end knows, which drifts little over so short a way.
/// \param ignores  scans that are left out
[[nodiscard]] FrozenSubmap submap_of_nodes(const NodeRange& nodes, std::size_t origin,
                                           const EditedPath& path,
                                           const std::function<bool(std::size_t scan)>& ignores);

/// Two places and where to look for the second one's scans in those of the first.
struct HandCandidate {
  std::size_t from = 0;  ///< the earlier node
  std::size_t to = 0;
  NodeRange from_nodes{};
  NodeRange to_nodes{};
  Pose2 from_T_to{};
  double half_xy_m = 0.0;
  double half_yaw_rad = 0.0;
};

/// Registers the scans around two places, and measures the result as loop closing does. Nothing
/// where no pose in the window scores well enough to be spoken of. Nodes and submaps are told.
/// Cost: some tens of milliseconds.
[[nodiscard]] std::optional<LoopClosure> register_places(
    const HandCandidate& candidate, const EditedPath& path,
    const std::function<bool(std::size_t scan)>& ignores);

}  // namespace loopstone
