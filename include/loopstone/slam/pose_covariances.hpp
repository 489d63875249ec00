#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

class SurfaceSystem;

/// How well the poses of a map are known, from all that held them: motions along the path, loop
/// closures, and the surfaces that key scans share.
///
/// Stretches of a dozen key scans count as rigid bodies (SurfaceSegments); between them motions
/// are compounded; none reaches over a break of the path. What a key scan adds to its stretch is
/// the covariance that it has while all others stand still. Copies share what they know. Not
/// thread-safe.
class PoseCovariances {
 public:
  /// Knows nothing.
  PoseCovariances() = default;
  /// \param graph     at its final poses; its gauge is held
  /// \param surfaces  linearised there, or none
  /// \param broken    of each pose, whether nothing held the motion from the one before; empty:
  ///                  nowhere
  explicit PoseCovariances(const PoseGraph& graph, const SurfaceSystem* surfaces = nullptr,
                           const std::vector<bool>& broken = {});

  /// False when some pose is held by nothing, or when there are no poses.
  [[nodiscard]] bool available() const { return knowledge_ != nullptr; }

  /// Of a pose against the held one, which is the first: (x, y, yaw), axes of the map [m^2, m rad,
  /// rad^2]; zero for held poses. Cost: once a stretch what lies between it and the root of an
  /// elimination tree, below a millisecond.
  [[nodiscard]] Eigen::Matrix3d of(NodeId node) const;
  /// The map is told in a frame that is turned: so are the axes of of() from now on.
  void turn_axes(double new_yaw_map_rad) { turned_rad_ += new_yaw_map_rad; }
  /// Of the motion from one pose to another, (x, y, yaw) in the first one's frame. Cost: as
  /// that of a stretch.
  [[nodiscard]] Eigen::Matrix3d between(NodeId from, NodeId to) const;

 private:
  struct Knowledge;
  std::shared_ptr<Knowledge> knowledge_{};
  double turned_rad_ = 0.0;  ///< since it was known
};

}  // namespace loopstone
