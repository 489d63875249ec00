#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/slam/path_surfaces.hpp"
#include "slam/path_chain.hpp"
#include "slam/surface_segments.hpp"

namespace loopstone {

struct PathSurfaces::Knowledge {
  std::vector<Pose2> poses;  ///< map_T_key where surfaces were linearised
  std::vector<int> places;
  SurfaceSegments segments;
};

/// A link from the middle of a segment of the path to that of the next, and which key scans those
/// are.
struct LinkAlong {
  SurfaceSegments::Link link;
  std::size_t from = 0;
  std::size_t to = 0;
};

/// Of motions from each key scan to the next; none where the path has a hole.
/// \param covariances  of the motion to each key scan from the one before, at its end, axes of the
///                     map
/// \param known        whether there is one
[[nodiscard]] std::vector<LinkAlong> links_along(std::span<const Pose2> map_T_key,
                                                 std::span<const int> places,
                                                 const SurfaceSegments& segments,
                                                 std::span<const Eigen::Matrix3d> covariances,
                                                 const std::vector<bool>& known);

/// How far a path may be off by what its steps may have lost and what the surfaces along it say
/// against that.
class PathPosterior {
 public:
  /// \param surfaces  available
  /// \param chain     at their poses; of `off`, and what its scale may be wrong by, so much as
  ///                  surfaces do not hold
  /// \param steps     covariances of the motions from each key scan to the next, at their ends,
  ///                  axes of the map; may be zero
  PathPosterior(PathSurfaces surfaces, const PathChain& chain,
                std::span<const Eigen::Matrix3d> steps);

  /// False where some part of the path is held by nothing.
  [[nodiscard]] bool available() const { return available_; }

  /// Middles of the stretches of key scans that move as rigid bodies, map frame.
  [[nodiscard]] std::vector<Eigen::Vector2d> places() const;
  /// A draw of errors (x, y, yaw) at the places, axes of the map.
  [[nodiscard]] std::vector<Eigen::Vector3d> draw(Rng rng);

  /// Covariance of the motion from a key scan to another, at the latter, axes of the map.
  [[nodiscard]] Eigen::Matrix3d between(std::size_t first, std::size_t last);

 private:
  using Motions = std::vector<Eigen::Vector3d>;  ///< of segments
  [[nodiscard]] Eigen::Vector3d at(const Motions& motions, std::size_t key) const;

  PathSurfaces surfaces_;  ///< keeps what is known alive
  PathSurfaces::Knowledge& knowledge_;
  double sigma_ = 1.0;                  ///< all that was drawn is wrong by that
  Motions by_scale_{};                  ///< one standard deviation
  Motions by_off_{};                    ///< the same
  std::vector<std::size_t> middles_{};  ///< of the segments, key scans
  bool available_ = false;
};

}  // namespace loopstone
