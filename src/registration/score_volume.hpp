#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "loopstone/registration/correlative_search.hpp"

namespace loopstone {

/// The likelihood's moments over the lattice poses around a peak.
struct ScoreVolume {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();  ///< of pose - peak: x, y, yaw
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  Eigen::Vector3d step = Eigen::Vector3d::Zero();  ///< of the lattice: x, y, yaw
  bool leaves_window = false;                      ///< a pose at the window's edge still counts
  std::int64_t evaluations = 0;
};

/// Grows outwards from the peak over all lattice poses that are joined to it and whose likelihood
/// is at least exp(-12) of its.
///
/// \param peak      a pose of the search's lattice
/// \param evidence  log likelihood of a point on a surface against one on nothing known
[[nodiscard]] ScoreVolume score_volume(std::span<const Eigen::Vector2d> source,
                                       const MaxPyramid& target, const SearchWindow& window,
                                       const Pose2& peak, double evidence);

}  // namespace loopstone
