#pragma once

#include <gtest/gtest.h>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/geometry/pose3.hpp"

namespace loopstone::test {

/// EXPECT_TRUE(pose_near(actual, expected, 0.01, 0.001)): heading errors are wrapped and compared
/// with abs; NaN is never near. The failure message names both poses and both errors.
[[nodiscard]] testing::AssertionResult pose_near(const Pose2& actual, const Pose2& expected,
                                                 double tolerance_m, double tolerance_rad);
[[nodiscard]] testing::AssertionResult pose_near(const Pose3& actual, const Pose3& expected,
                                                 double tolerance_m, double tolerance_rad);

}  // namespace loopstone::test
