#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

/// A loop closure with what every comparison needs, told from the pose of lower index.
struct ComparedClosure {
  std::size_t edge = 0;  ///< index in the graph
  std::size_t from = 0;
  std::size_t to = 0;
  Pose2 from_T_to{};
  Eigen::Matrix3d covariance;  ///< twist at the end
};

/// Loops of two closures and the odometry between them: a.from -> b.from by odometry, b, b.to ->
/// a.to by odometry, a backwards. Mangelson et al. 2018, eq. 8.
class ClosureLoops {
 public:
  /// Finds the chain of odometry edges between consecutive poses, and the closures.
  explicit ClosureLoops(const PoseGraph& graph);

  [[nodiscard]] const std::vector<ComparedClosure>& closures() const { return closures_; }
  /// By odometry alone, from the first pose of each part.
  [[nodiscard]] const std::vector<Pose2>& poses() const { return poses_; }

  /// Whether odometry joins the ends of two closures.
  [[nodiscard]] bool joined(const ComparedClosure& a, const ComparedClosure& b) const {
    return part_[a.from] == part_[b.from] && part_[a.to] == part_[b.to];
  }

  struct Opening {
    double chi2 = 0.0;         ///< how open the loop is, in squared standard deviations
    double determinant = 0.0;  ///< of the covariance that is expected of it [m^4 rad^2]
  };
  [[nodiscard]] Opening opening(const ComparedClosure& a, const ComparedClosure& b) const;

  /// Covariance of the way between two poses by odometry, as a twist in the frame in which the
  /// chain is told.
  [[nodiscard]] Eigen::Matrix3d stretch(std::size_t i, std::size_t k) const {
    return grown_[i < k ? k : i] - grown_[i < k ? i : k];
  }

 private:
  std::vector<Pose2> poses_;
  std::vector<Eigen::Matrix3d> grown_;
  std::vector<int> part_;  ///< poses of different parts are not joined by odometry
  std::vector<ComparedClosure> closures_;
};

}  // namespace loopstone
