#include "loopstone/geometry/rigid_motion.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "support/generators.hpp"

namespace loopstone {
namespace {

template <int kDimension>
void check_laws(const typename RigidMotion<kDimension>::Pose& pose,
                const typename RigidMotion<kDimension>::Tangent& motion,
                const typename RigidMotion<kDimension>::Vector& point) {
  using Motion = RigidMotion<kDimension>;
  // Moving by the difference leads there.
  const auto moved = Motion::moved(pose, motion);
  const auto again = Motion::moved(pose, Motion::difference(moved, pose));
  RC_ASSERT((again * point - moved * point).norm() < 1e-7);
  // Rotation and translation make up the pose.
  const auto rebuilt = Motion::pose(Motion::rotation(pose), Motion::translation(pose));
  RC_ASSERT((rebuilt * point - pose * point).norm() < 1e-7);
  // The Jacobian is the derivative.
  const auto jacobian = Motion::point_jacobian(Motion::rotation(pose) * point);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < Motion::kDof; ++i) {
    typename Motion::Tangent along = Motion::Tangent::Zero();
    along(i) = kStep;
    const typename Motion::Vector numeric =
        (Motion::moved(pose, along) * point - Motion::moved(pose, -along) * point) / (2.0 * kStep);
    RC_ASSERT((numeric - jacobian.col(i)).norm() < 1e-6);
  }
}

RC_GTEST_PROP(RigidMotion, LawsHoldInThePlane, ()) {
  const auto pose = *test::any_pose2();
  const auto motion = *test::any_tangent2();
  check_laws<2>(pose, motion, {*test::between(-5.0, 5.0), *test::between(-5.0, 5.0)});
}

RC_GTEST_PROP(RigidMotion, LawsHoldInSpace, ()) {
  const auto pose = exp(*test::any_tangent3());
  const auto motion = *test::any_tangent3();
  check_laws<3>(pose, motion,
                {*test::between(-5.0, 5.0), *test::between(-5.0, 5.0), *test::between(-5.0, 5.0)});
}

}  // namespace
}  // namespace loopstone
