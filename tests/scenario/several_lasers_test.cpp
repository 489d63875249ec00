// Robots with several lasers, held against one laser alone.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "loopstone/geometry/angle.hpp"
#include "mapped_drives.hpp"

namespace loopstone::test {
namespace {

/// What one of the robot's lasers sees of a drive; the drive is the same whatever the laser.
SimulatedLog seen_from(const Pose2& robot_T_lidar, double rate_hz, const std::string& world,
                       std::uint64_t seed) {
  RobotModel robot;
  robot.lidars[0].robot_T_lidar = robot_T_lidar;
  SimulationOptions options{.duration_s = small_scale() ? 40.0 : 150.0, .odometry_poses = true};
  options.laser.rate_hz = rate_hz;
  options.laser.beams = 361;
  options.laser.fov_rad = kPi;
  options.laser.range_max_m = 6.0;
  SimulatedLog log = simulate_log(world, seed, options, robot);
  for (SensorMessage& message : log.messages) {
    if (auto* scan = std::get_if<LaserScan>(&message)) scan->robot_T_lidar = robot_T_lidar;
  }
  return log;
}

/// Both lasers' scans in the order of their stamps, which run apart.
SimulatedLog both(const SimulatedLog& front, const SimulatedLog& rear) {
  SimulatedLog log = front;
  for (LaserScan scan : rear.scans()) {
    scan.lidar = 1;
    log.messages.emplace_back(std::move(scan));
  }
  std::ranges::stable_sort(log.messages, {}, stamp_of);
  return log;
}

SimulatedLog without_odometry(SimulatedLog log) {
  std::erase_if(log.messages, [](const SensorMessage& message) {
    return !std::holds_alternative<LaserScan>(message);
  });
  return log;
}

class SeveralLasers : public testing::TestWithParam<const char*> {
 protected:
  /// On opposite corners, facing away from one another.
  const Pose2 front_{0.3, 0.2, radians(45.0)};
  const Pose2 rear_{-0.3, -0.2, radians(-135.0)};
  const SimulatedLog front_log_ = seen_from(front_, 10.0, GetParam(), 31);
  const SimulatedLog rear_log_ = seen_from(rear_, 11.0, GetParam(), 31);
};

TEST_P(SeveralLasers, TwoCornersMapAsWellAsTheBetterOneAlone) {
  const MapResult alone = map_of(front_log_);
  const MapResult other = map_of(rear_log_);
  const MapResult result = map_of(both(front_log_, rear_log_));
  EXPECT_EQ(result.statistics.scans, alone.statistics.scans + other.statistics.scans);
  const double best_m = std::min(
      ate_rmse_m(alone.trajectory, front_log_),
      absolute_error(other.trajectory, front_log_.truth, Alignment::kSe2).translation_m.rmse);
  const double error_m = ate_rmse_m(result.trajectory, front_log_);
  EXPECT_LT(error_m, 1.4 * best_m + 0.003);
  EXPECT_LE(result.statistics.searches, result.statistics.scans / 50) << "scans fit at once";
}

TEST_P(SeveralLasers, HoldOneAnotherWithoutOdometry) {
  const MapResult result = map_of(without_odometry(both(front_log_, rear_log_)));
  const MapResult alone = map_of(without_odometry(front_log_));
  const double alone_m = ate_rmse_m(alone.trajectory, front_log_);
  const double error_m = ate_rmse_m(result.trajectory, front_log_);
  EXPECT_LT(error_m, 1.5 * alone_m + 0.008);
}

std::string world_name(const testing::TestParamInfo<const char*>& info) { return info.param; }

INSTANTIATE_TEST_SUITE_P(Worlds, SeveralLasers, testing::Values("office", "warehouse"), world_name);

}  // namespace
}  // namespace loopstone::test
