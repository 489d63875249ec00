#include "registration/open_translation.hpp"

#include <algorithm>
#include <cmath>

#include "loopstone/base/hypotenuse.hpp"

namespace loopstone {

namespace {

/// Translation counts as unobserved along a direction that has less than this share of the best
/// direction's information.
constexpr double kDegenerateShare = 0.01;
/// ... or less than so many points facing along it give. Observability, by which the other matchers
/// judge, has no such floor: of 26,209 matches while mapping ACES, Intel and MIT CSAIL this rule
/// calls 898 degenerate, that one 304 of these and 2 others; it never found a heading open. Without
/// the floor maps are as accurate (35 and 15 mm), with 3.6 m of degenerate travel in ACES, not 28
/// m.
constexpr double kDegeneratePoints = 2.0;

/// Information on the translation once the heading is free too: the Schur complement.
Eigen::Matrix2d translation_of(const Eigen::Matrix3d& hessian) {
  const Eigen::Vector2d coupling = hessian.topRightCorner<2, 1>();
  return hessian.topLeftCorner<2, 2>() - coupling * coupling.transpose() / hessian(2, 2);
}

}  // namespace

Eigen::Vector2d weakest_direction(const Eigen::Matrix3d& hessian) {
  if (!(hessian(2, 2) > 0.0)) return Eigen::Vector2d::Zero();
  const Eigen::Matrix2d translation = translation_of(hessian);
  const double strong =
      0.5 * std::atan2(2.0 * translation(0, 1), translation(0, 0) - translation(1, 1));
  return {-std::sin(strong), std::cos(strong)};
}

std::optional<OpenTranslation> open_translation(const Eigen::Matrix3d& hessian) {
  const double heading = hessian(2, 2);
  if (!(heading > 0.0)) {
    return OpenTranslation{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), 0.0};
  }
  const Eigen::Matrix2d translation = translation_of(hessian);
  const double middle = 0.5 * (translation(0, 0) + translation(1, 1));
  const double spread =
      hypotenuse(0.5 * (translation(0, 0) - translation(1, 1)), translation(0, 1));
  if (middle - spread >= std::max(kDegenerateShare * (middle + spread), kDegeneratePoints))
    return {};
  Eigen::Vector3d motion = Eigen::Vector3d::Zero();
  motion.head<2>() = weakest_direction(hessian);
  motion.z() = -hessian.topRightCorner<2, 1>().dot(motion.head<2>()) / heading;
  const Eigen::Vector3d along = hessian * motion;
  return OpenTranslation{motion, along, std::max(motion.dot(along), 0.0)};
}

}  // namespace loopstone
