#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/messages/message_types.hpp"
#include "loopstone/odometry/trajectory.hpp"
#include "loopstone/slam/loop_closure.hpp"
#include "loopstone/slam/map_result.hpp"
#include "loopstone/slam/map_update.hpp"

// A map and what becomes of it, as messages of ROS.

namespace loopstone {

[[nodiscard]] msg::OccupancyGrid to_message(const CellStates& cells, Stamp stamp);

[[nodiscard]] msg::Path path_message(const std::vector<StampedPose2>& poses, Stamp stamp);

/// Their origins as points, their numbers as text. \param map_T_submap  by their numbers
[[nodiscard]] msg::MarkerArray submap_markers(const std::vector<Pose2>& map_T_submap, Stamp stamp);

/// A closure on the map.
struct ClosureLine {
  ClosureState state = ClosureState::kRejected;
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
  friend bool operator==(const ClosureLine&, const ClosureLine&) = default;
};
/// Between the places of its nodes on the path as it was delivered.
[[nodiscard]] std::vector<ClosureLine> closure_lines(const MapResult& result);
/// Each state has its list of lines, or a marker that says that there are none any more.
[[nodiscard]] msg::MarkerArray closure_markers(const std::vector<ClosureLine>& lines, Stamp stamp);

/// Of events that begin or end a fault.
[[nodiscard]] std::optional<msg::DiagnosticStatus> diagnostic_of(const MapEvent& event);
[[nodiscard]] msg::DiagnosticStatus diagnostic_of(const MapUpdate& update);
/// The verdict with all measures, then each measure by itself, then the warnings.
[[nodiscard]] std::vector<msg::DiagnosticStatus> diagnostics_of(const MapResult& result);

}  // namespace loopstone
