#pragma once

#include <Eigen/Core>
#include <optional>

namespace loopstone {

/// A motion that the points of a scan leave open.
struct OpenTranslation {
  Eigen::Vector3d motion;  ///< (x, y, yaw), unit translation; turns with it as the points want
  Eigen::Vector3d along;   ///< H motion
  double information;      ///< motion^T H motion
};

/// The direction of translation of which points know next to nothing, as along a bare corridor:
/// what little they seem to say about it is noise of the normals.
/// \param hessian  H, sum of w J^T J over the points, J = d distance / d (x, y, yaw) in unit
///                 distances, of weight 1 for a good point
/// \return nothing where all directions are held. A direction without any information has
///         information 0. Source: Zhang, Kaess and Singh 2016, "On degeneracy of optimization-based
///         state estimation problems".
[[nodiscard]] std::optional<OpenTranslation> open_translation(const Eigen::Matrix3d& hessian);
/// The unit direction of translation that they hold least, whether they leave it open or not; zero
/// where nothing holds the heading.
[[nodiscard]] Eigen::Vector2d weakest_direction(const Eigen::Matrix3d& hessian);

}  // namespace loopstone
