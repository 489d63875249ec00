#include "loopstone/localization/localizer.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "drawn_room.hpp"
#include "loopstone/geometry/pose_distance.hpp"
#include "support/pose_near.hpp"
#include "support/simulated_log.hpp"

namespace loopstone {
namespace {

using test::furnished_room;
using test::pose_near;
using test::scan_from;
using test::Walls;

const Pose2 kHere{6.5, 4.5, -2.0};
const Pose2 kElsewhere{1.5, 1.0, 1.4};

/// A robot that stands in a room, and a localiser that looks nowhere but where it is told.
class LocalizerRestart : public testing::Test {
 protected:
  void stand(int scans) {
    for (int i = 0; i < scans; ++i) {
      const Stamp stamp = Stamp::from_seconds(0.1 * ++scans_);
      LaserScan scan = scan_from(room_, kHere, robot_.lidars.at(0).robot_T_lidar, {});
      scan.stamp = stamp;
      localizer_.add(OdometryPose{stamp, {1.0, 2.0, 0.5}});
      localizer_.add(scan);
    }
    while (auto estimate = localizer_.next_update()) last_ = *estimate, ++estimates_;
  }

  const Walls room_ = furnished_room();
  const LocalizationMap map_{test::drawn(room_, {0.0, 0.0}, {8.0, 6.0})};
  const LocalizationOptions options_{.recover = false};
  const RobotModel robot_{};
  Localizer localizer_{map_, robot_, options_, InitialPose{kElsewhere, 0.2, 0.1}, 1};
  int scans_ = 0;
  int estimates_ = 0;
  std::optional<LocalizationEstimate> last_{};
};

TEST_F(LocalizerRestart, SomebodySaysWhereItIsAndItIsThere) {
  stand(5);
  ASSERT_TRUE(last_);
  EXPECT_FALSE(is_within(last_->map_T_robot, kHere, 1.0, 0.5));
  localizer_.restart_at({kHere * Pose2{0.2, -0.2, 0.1}, 0.3, 0.15});
  stand(5);
  EXPECT_TRUE(pose_near(last_->map_T_robot, kHere, 0.05, 0.02));
}

TEST_F(LocalizerRestart, OdometryAndEstimatesGoOn) {
  stand(5);
  const Pose2 odom_T_robot = last_->odom_T_robot;
  localizer_.restart_at({kHere, 0.3, 0.15});
  stand(5);
  EXPECT_TRUE(pose_near(last_->odom_T_robot, odom_T_robot, 1e-9, 1e-9));
  const LocalizationResult result = localizer_.finish();
  EXPECT_EQ(result.scans, 10);
  EXPECT_EQ(result.estimates.size(), 10U);
}

TEST_F(LocalizerRestart, BeforeTheFirstScanIsAsIfItHadBegunThere) {
  localizer_.restart_at({kHere, 0.3, 0.15});
  stand(5);
  EXPECT_TRUE(pose_near(last_->map_T_robot, kHere, 0.05, 0.02));
}

}  // namespace
}  // namespace loopstone
