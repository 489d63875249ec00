#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/base/words.hpp"
#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

/// Why the laser did not hold the robot's pose for a while.
enum class BreakCause {
  kNoScans,       ///< there were none, or none that could be used
  kContradicted,  ///< scans contradict what was seen before, wherever the robot is looked for
  kCarried,       ///< there were none, and the first one after contradicts what was seen before
                  ///< where odometry says that the robot stood
  kLifted,        ///< it was turned while its wheels stood, in somebody's hands, and the laser
                  ///< left open how far it was carried
  kNewDrive,      ///< another drive begins, nothing tells where
};

constexpr auto words_of(BreakCause /*any*/) {
  using enum BreakCause;
  return std::array{Word{kNoScans, "no_scans"}, Word{kContradicted, "contradicted"},
                    Word{kCarried, "carried"}, Word{kLifted, "lifted"},
                    Word{kNewDrive, "new_drive"}};
}

/// What carried the pose across.
enum class BreakBridge {
  kLaser,     ///< the first scan after it fits what was seen before
  kOdometry,  ///< the laser sees a place that it did not know
  kNothing,   ///< no odometry that could be trusted either: where the path goes on is a guess
};

constexpr auto words_of(BreakBridge /*any*/) {
  using enum BreakBridge;
  return std::array{Word{kLaser, "laser"}, Word{kOdometry, "odometry"}, Word{kNothing, "nothing"}};
}

/// A time during which the laser did not hold the robot's pose.
struct PathBreak {
  Stamp from{};             ///< of the last scan that the laser held
  Stamp to{};               ///< of the first scan after
  std::size_t to_scan = 0;  ///< beyond the last one where the log ended meanwhile
  BreakCause cause = BreakCause::kNoScans;
  BreakBridge bridge = BreakBridge::kLaser;
  double odometry_m = 0.0;  ///< path across as odometry has it; 0 when it can't be trusted
  bool ends_log = false;    ///< no scan held the pose again; of finished maps only
  /// Of the motion across without the laser, (x, y, yaw), local frame.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  // Told when the map is finished:
  int closures = 0;  ///< that stand and lead from one side to the other
  /// How far both sides may be off to one another [m], one standard deviation, by the best of
  /// bridge and closures.
  double tie_sigma_m = std::numeric_limits<double>::infinity();

  [[nodiscard]] double bridge_sigma_m() const;
  /// Nothing told how it moved, but part of what it saw then had been seen, and fits in one place.
  [[nodiscard]] bool was_found_in_part() const;
  /// Odometry says that the robot stood, but along what it sees then somebody may have carried it.
  [[nodiscard]] bool may_be_carried() const;

  template <typename Archive>
  void archive(Archive& a) {
    a(from, to, to_scan, cause, bridge, odometry_m, covariance, closures, tie_sigma_m);
  }
};

/// Tells of each break what ties both its sides.
/// \param graph       at its end, with the closures that stand
/// \param node_scans  of each pose of the graph, the place of its scan among all scans
void find_ties(std::vector<PathBreak>& breaks, const PoseGraph& graph,
               std::span<const std::size_t> node_scans);

}  // namespace loopstone
