#pragma once

#include <Eigen/Core>
#include <span>

#include "loopstone/base/words.hpp"
#include "loopstone/geometry/rigid_motion.hpp"

namespace loopstone {

/// Where an alignment starts when nothing better is known. A guess that is given needs no help; to
/// find one from nothing there are the searches.
enum class IcpGuess {
  kIdentity,   ///< the clouds lie as they are
  kCentroids,  ///< the source is shifted, not turned, so that the means of both clouds coincide
};

constexpr auto words_of(IcpGuess /*any*/) {
  using enum IcpGuess;
  return std::array{Word{kIdentity, "identity"}, Word{kCentroids, "centroids"}};
}

/// The guess target_T_source. Points that are not finite are ignored; a cloud without points leaves
/// the identity.
template <int kDimension>
[[nodiscard]] typename RigidMotion<kDimension>::Pose initial_guess(
    IcpGuess guess, std::span<const Eigen::Matrix<double, kDimension, 1>> source,
    std::span<const Eigen::Matrix<double, kDimension, 1>> target);

extern template Pose2 initial_guess<2>(IcpGuess, std::span<const Eigen::Vector2d>,
                                       std::span<const Eigen::Vector2d>);
extern template Pose3 initial_guess<3>(IcpGuess, std::span<const Eigen::Vector3d>,
                                       std::span<const Eigen::Vector3d>);

}  // namespace loopstone
