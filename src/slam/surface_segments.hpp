#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
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
  /// \param size    of the vectors; places that no key scan has are of landmarks, which are no part
  ///                of any segment: as seen from afar they stand still
  /// \param ends    of each key scan, whether a segment ends before it, besides those that are long
  ///                enough; empty: no others
  SurfaceSegments(std::span<const Pose2> map_T_key, std::span<const int> places, std::size_t size,
                  const std::vector<bool>& ends = {});

  /// What is measured between two key scans, or of one (from < 0) against those that are held.
  struct Link {
    int from = -1;  ///< place
    int to = -1;
    Eigen::Vector2d from_T_point = Eigen::Vector2d::Zero();  ///< where it is measured: from the key
    Eigen::Vector2d to_T_point = Eigen::Vector2d::Zero();    ///< scans, axes of the map
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();   ///< of the relative motion there
  };

  /// Factorises what the surfaces and the graph say of the segments' motions. False when that is
  /// not positive definite.
  [[nodiscard]] bool factorise(const SurfaceSystem& surfaces, const BlockMatrix& graph);
  /// The same with links for the graph.
  [[nodiscard]] bool factorise(const SurfaceSystem* surfaces, std::span<const Link> links);

  /// The same in two steps, for links that are known later: what the surfaces say, with room for
  /// links from each segment to the next.
  void gather(const SurfaceSystem& surfaces);
  /// After gather(), any number of times.
  [[nodiscard]] bool factorise_along(std::span<const Link> links);

  /// z += P (P^T S P)^-1 P^T r with P from segments' motions to those of key scans.
  void add_correction(std::span<const Eigen::Vector3d> r, std::span<Eigen::Vector3d> z);

  [[nodiscard]] int segment_of(int place) const {
    return members_[static_cast<std::size_t>(place)].segment;
  }
  [[nodiscard]] std::size_t size() const { return centres_.size(); }
  /// Motion of a point fixed to a key scan's segment, `offset` from the key scan, from the
  /// segment's motion.
  [[nodiscard]] Eigen::Matrix3d motion_at(int place, const Eigen::Vector2d& offset) const;
  /// J S^-1 J^T with rows J that stand at segments. After factorise() alone.
  [[nodiscard]] Eigen::Matrix3d through_inverse(std::span<const BlockSolver::RowsAt> j) {
    return solver_->through_inverse(j);
  }
  /// How segments move where motions of links are off by so much (x, y), axes of the map, and all
  /// that was factorised holds against it. In the order of segment_of().
  [[nodiscard]] std::vector<Eigen::Vector3d> response_to(std::span<const Link> links,
                                                         std::span<const Eigen::Vector2d> off);
  /// Noise of unit covariance, one vector for each segment, becomes motions of segments as likely
  /// as what was factorised says. In the order of segment_of().
  void colour_in_place(std::span<Eigen::Vector3d> z) { solver_->colour_in_place(z); }

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
  /// \param linked  pairs of places
  void build_pattern(const SurfaceSystem* surfaces, std::span<const std::pair<int, int>> linked);
  void add_surfaces(const SurfaceSystem& surfaces);
  void add_links(std::span<const Link> links);
  /// Adds to the block (row, column), and so to (column, row).
  void add(int row, int column, const Eigen::Matrix3d& value);

  std::vector<Member> members_{};           ///< by place
  std::vector<Eigen::Vector2d> centres_{};  ///< of segments, map frame
  BlockMatrix matrix_{};                    ///< segments in order of elimination
  std::optional<BlockSolver> solver_{};
  std::vector<Eigen::Vector3d> moved_{};
};

}  // namespace loopstone
