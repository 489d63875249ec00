#include "support/pose_near.hpp"

#include <cmath>

#include "loopstone/geometry/angle.hpp"

namespace loopstone::test {

namespace {

testing::AssertionResult judge(double error_m, double error_rad, double tolerance_m,
                               double tolerance_rad) {
  // Written so that NaN fails.
  if (error_m <= tolerance_m && error_rad <= tolerance_rad) {
    return testing::AssertionSuccess() << "off by " << error_m << " m and " << error_rad << " rad";
  }
  return testing::AssertionFailure()
         << "off by " << error_m << " m (allowed " << tolerance_m << ") and " << error_rad
         << " rad (allowed " << tolerance_rad << ")";
}

}  // namespace

testing::AssertionResult pose_near(const Pose2& actual, const Pose2& expected, double tolerance_m,
                                   double tolerance_rad) {
  const double error_m = std::hypot(actual.x - expected.x, actual.y - expected.y);
  const double error_rad = std::abs(wrap_angle(actual.yaw - expected.yaw));
  return judge(error_m, error_rad, tolerance_m, tolerance_rad)
         << ": (" << actual.x << ", " << actual.y << ", " << actual.yaw << ") against ("
         << expected.x << ", " << expected.y << ", " << expected.yaw << ")";
}

testing::AssertionResult pose_near(const Pose3& actual, const Pose3& expected, double tolerance_m,
                                   double tolerance_rad) {
  const double error_m = (actual.translation - expected.translation).norm();
  const double error_rad = actual.rotation.angularDistance(expected.rotation);
  return judge(error_m, error_rad, tolerance_m, tolerance_rad)
         << ": (" << actual.translation.transpose() << "; " << actual.rotation.coeffs().transpose()
         << ") against (" << expected.translation.transpose() << "; "
         << expected.rotation.coeffs().transpose() << ")";
}

}  // namespace loopstone::test
