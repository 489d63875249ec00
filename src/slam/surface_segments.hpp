#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/graph/block_system.hpp"
#include "slam/surface_system.hpp"

namespace loopstone {

/// The adjustment as seen from afar: stretches of consecutive key scans that move as rigid bodies.
/// The slow waves of a map, which conjugate gradients find last, are exactly those; so they are
/// solved for directly (two-level preconditioner: Toselli and Widlund 2005, "Domain decomposition
/// methods", chapter 2).
class SurfaceSegments {
 public:
  /// \param places  of each key scan in vectors, -1 where it is held
  SurfaceSegments(std::span<const Pose2> map_T_key, std::span<const int> places);

  /// Factorises what the surfaces and the graph say of the segments' motions. False when that is
  /// not positive definite.
  [[nodiscard]] bool factorise(const SurfaceSystem& surfaces, const BlockMatrix& graph);

  /// z += P (P^T S P)^-1 P^T r with P from segments' motions to those of key scans.
  void add_correction(std::span<const Eigen::Vector3d> r, std::span<Eigen::Vector3d> z);

 private:
  /// Where a key scan lies in its segment.
  struct Member {
    int segment = -1;
    double x = 0.0;  ///< from the segment's centre
    double y = 0.0;
  };
  struct Group;
  /// Its motion from the segment's.
  [[nodiscard]] static Eigen::Matrix3d motion_of(const Member& member);
  template <typename Visitor>
  void for_each_patch(const SurfaceSystem& surfaces, Visitor&& visit) const;
  void build_pattern(const SurfaceSystem& surfaces, const BlockMatrix& graph);
  /// Adds to the block (row, column), and so to (column, row).
  void add(int row, int column, const Eigen::Matrix3d& value);

  std::vector<Member> members_{};           ///< by place
  std::vector<Eigen::Vector2d> centres_{};  ///< of segments, map frame
  BlockMatrix matrix_{};                    ///< segments in order of elimination
  std::optional<BlockSolver> solver_{};
  std::vector<Eigen::Vector3d> moved_{};
};

}  // namespace loopstone
