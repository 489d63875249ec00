#include "loopstone/geometry/roll_pitch_yaw.hpp"

#include <gtest/gtest.h>

namespace loopstone {
namespace {

TEST(RollPitchYaw, InverseOfFromRollPitchYaw) {
  for (double roll = -3.0; roll <= 3.0; roll += 0.75) {
    for (double pitch = -1.5; pitch <= 1.5; pitch += 0.5) {
      for (double yaw = -3.0; yaw <= 3.0; yaw += 0.75) {
        const Eigen::Vector3d back =
            to_roll_pitch_yaw(Pose3::from_roll_pitch_yaw({1, 2, 3}, roll, pitch, yaw));
        EXPECT_LT((back - Eigen::Vector3d(roll, pitch, yaw)).norm(), 1e-9)
            << roll << ' ' << pitch << ' ' << yaw;
      }
    }
  }
}

}  // namespace
}  // namespace loopstone
