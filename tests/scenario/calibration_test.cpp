// Simulated robots whose laser does not sit where the robot file says.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/slam/robot_correction.hpp"
#include "mapped_drives.hpp"

namespace loopstone::test {
namespace {

SimulationOptions office_options(bool mount_is_wrong) {
  SimulationOptions options{.duration_s = 240.0};
  options.laser.rate_hz = 5.0;
  options.laser.beams = 361;
  options.realism.mount.on = mount_is_wrong;
  return options;
}

double heading_error_rad(const MapResult& result, const SimulatedLog& log) {
  return absolute_error(result.trajectory, log.truth, Alignment::kSe2).rotation_rad.rmse;
}

TEST(CalibrationSimulated, AMountThatIsWrongIsPutRight) {
  const SimulatedLog log = simulate_log("office", 1, office_options(true));
  const MapResult right = map_of(log);
  const Calibration& found = right.calibration;
  ASSERT_TRUE(found.is_corrected);
  EXPECT_LT(heading_error_rad(right, log), radians(0.1));
  ASSERT_FALSE(right.warnings.empty());
  EXPECT_NE(right.warnings.front().find("of where its mount says"), std::string::npos);

  const MapResult as_told = map_of(log, {.calibration = false});
  EXPECT_GT(heading_error_rad(as_told, log), radians(0.5)) << "else this shows nothing";
  EXPECT_LT(ate_rmse_m(right.trajectory, log), 0.4 * ate_rmse_m(as_told.trajectory, log));
  EXPECT_EQ(as_told.calibration.motions, 0);

  // The same scans lie on the same walls: only the centre that is told is another one.
  const Pose2 new_T_old = found.robot_T_lidar() * found.robot_T_lidar_given.inverse();
  ASSERT_EQ(right.trajectory.size(), as_told.trajectory.size());
  for (std::size_t i = 0; i < right.trajectory.size(); i += 50) {
    const Pose2 told = new_T_old * as_told.trajectory.poses()[i].pose * new_T_old.inverse();
    const Pose2 difference = told.inverse() * right.trajectory.poses()[i].pose;
    EXPECT_LT(difference.vector().norm(), 1e-9) << i;
  }
  EXPECT_LT(right.trajectory.front().pose.vector().norm(), 0.01) << "still the origin";
  EXPECT_NEAR(graph_cost(right.graph), graph_cost(as_told.graph), 1e-3 * graph_cost(as_told.graph));
  for (std::size_t i = 0; i < right.graph.poses.size(); i += 20) {
    const Pose2 at = *right.trajectory.at(right.node_stamps[i]);
    EXPECT_LT((at.inverse() * right.graph.poses[i]).vector().norm(), 1e-9) << i;
  }
}

TEST(CalibrationSimulated, AMountThatIsRightIsLeftAlone) {
  const SimulatedLog log = simulate_log("office", 1, office_options(false));
  const MapResult result = map_of(log);
  EXPECT_FALSE(result.calibration.mount_is_off());
  EXPECT_GT(result.calibration.motions, 200);
  EXPECT_TRUE(result.calibration.lidar_x_m.observable);
  EXPECT_TRUE(result.calibration.lidar_yaw_rad.observable);
  const MapResult as_told = map_of(log, {.calibration = false});
  for (std::size_t i = 0; i < result.trajectory.size(); i += 50)
    EXPECT_EQ(result.trajectory.poses()[i].pose, as_told.trajectory.poses()[i].pose);
}

TEST(CalibrationSimulated, ALogThatAsksForTheLasersPathGetsIt) {
  SimulationOptions options = office_options(true);
  SimulatedLog log = simulate_log("office", 1, options);
  for (SensorMessage& message : log.messages) {
    if (auto* scan = std::get_if<LaserScan>(&message)) scan->robot_T_lidar = Pose2{};
  }
  const MapResult result = map_of(log);
  EXPECT_TRUE(result.calibration.place_is_off);
  EXPECT_FALSE(result.calibration.is_corrected);
}

/// As the program does it: the log once more where the first map asks for it.
MapResult map_of_corrected(const SimulatedLog& log, const Calibration& by_first) {
  const Calibration found = beside({}, by_first);
  Mapper mapper(corrected_robot(log.robot, found), {});
  for (const auto& message : log.messages) mapper.add(message);
  MapResult result = mapper.finish();
  tell_of_correction(found, result);
  return result;
}

TEST(CalibrationSimulated, ALaserUpsideDownIsNoticedAndTheMapMadeAnew) {
  SimulationOptions options = office_options(false);
  options.duration_s = 120.0;
  options.realism.upside_down.on = true;
  const SimulatedLog log = simulate_log("office", 2, options);
  const MapResult first = map_of(log);
  ASSERT_TRUE(first.calibration.laser_is_mirrored);
  EXPECT_GT(ate_rmse_m(first.trajectory, log), 0.5) << "else this shows nothing";
  const MapResult second = map_of_corrected(log, first.calibration);
  EXPECT_LT(ate_rmse_m(second.trajectory, log), 0.02);
  EXPECT_FALSE(second.calibration.turns_opposite);
  EXPECT_TRUE(second.calibration.beams_corrected);
  ASSERT_FALSE(second.warnings.empty());
  EXPECT_NE(second.warnings.front().find("upside down"), std::string::npos);
}

/// Turns on the spot, which tell which way a laser's beams go, may all fall into the time in which
/// odometry was wrong.
TEST(CalibrationSimulated, OdometryThatTurnsTheOtherWayForAWhileIsNoLaserUpsideDown) {
  SimulationOptions options{.duration_s = 240.0, .odometry_poses = true};
  options.laser.rate_hz = 6.0;
  options.laser.beams = 360;
  options.laser.fov_rad = radians(359.0);
  options.laser.range_max_m = 8.0;
  choose_realism(options.realism, "usual");
  options.faults = {.odometry = SimulatedOdometryFault::kMirrored, .from_s = 60.0, .to_s = 120.0};
  for (const std::uint64_t seed : {2057U, 2058U, 2059U}) {
    const SimulatedLog log = simulate_log("warehouse", seed, options);
    EXPECT_FALSE(map_of(log).calibration.laser_is_mirrored) << "seed " << seed;
  }
}

/// In a hall, scans of a mirrored laser are never placed by what they show, but they turn.
TEST(CalibrationSimulated, ALaserUpsideDownIsNoticedWhereNoScanFits) {
  SimulationOptions options{.duration_s = 120.0};
  options.laser.beams = 181;
  choose_realism(options.realism, "usual,upside_down");
  const SimulatedLog log = simulate_log("hall", 13, options);
  const MapResult first = map_of(log);
  ASSERT_TRUE(first.calibration.laser_is_mirrored);
  EXPECT_GT(ate_rmse_m(first.trajectory, log), 3.0) << "else this shows nothing";
  const MapResult second = map_of_corrected(log, first.calibration);
  EXPECT_FALSE(second.calibration.turns_opposite);
  EXPECT_LT(ate_rmse_m(second.trajectory, log), 0.5);
}

/// Largest distance from the first pose, too long in the map by.
double too_long_m(const Trajectory& path, const Trajectory& truth) {
  const auto reach = [](const Trajectory& of) {
    double most = 0.0;
    for (const StampedPose2& pose : of.poses()) {
      const Eigen::Vector2d way = pose.pose.translation() - of.front().pose.translation();
      most = std::max(most, way.norm());
    }
    return most;
  };
  return reach(path) - reach(truth);
}

TEST(CalibrationSimulated, ACorridorThatWasDrivenFirstIsAsLongAsTheScaleThatIsLearnedLater) {
  SimulationOptions options;
  options.laser.rate_hz = 5.0;
  options.laser.beams = 181;
  const SimulatedLog log = simulate_log("corridor", 1, options);
  const MapResult first = map_of(log);
  const Calibration& found = first.calibration;
  ASSERT_TRUE(found.scale_is_off);
  EXPECT_GT(too_long_m(first.trajectory, log.truth), 0.5) << "else this shows nothing";
  EXPECT_NEAR(found.open_travel_error_m, too_long_m(first.trajectory, log.truth), 1.0);
  EXPECT_NE(first.verdict.overall, Verdict::kGood);
  const MapResult second = map_of_corrected(log, found);
  EXPECT_LT(std::abs(too_long_m(second.trajectory, log.truth)), 0.15);
  EXPECT_TRUE(second.calibration.scale_corrected);
  EXPECT_NE(second.warnings.front().find("odometry's way is"), std::string::npos);
}

TEST(CalibrationSimulated, BesideDeadReckoningAloneALaserUpsideDownIsLikelierAndDoubted) {
  SimulationOptions options = office_options(false);
  options.duration_s = 120.0;
  options.realism.upside_down.on = true;
  options.odometry_poses = true;
  const SimulatedLog log = simulate_log("office", 2, options);
  const MapResult first = map_of(log);
  EXPECT_TRUE(first.calibration.turns_opposite);
  EXPECT_TRUE(first.calibration.laser_is_mirrored);
  EXPECT_TRUE(first.calibration.mirror_is_in_doubt);
  const MapResult second = map_of_corrected(log, first.calibration);
  EXPECT_LT(ate_rmse_m(second.trajectory, log), 0.03);
  EXPECT_TRUE(second.calibration.mirror_is_in_doubt);
  EXPECT_EQ(second.verdict.overall, Verdict::kDoubtful) << second.verdict.sentence;
  ASSERT_FALSE(second.warnings.empty());
  EXPECT_NE(second.warnings.front().find("mirror image"), std::string::npos);
}

TEST(CalibrationSimulated, CountsAloneThatTurnTheOtherWayMayBeWrongThemselves) {
  SimulationOptions options = office_options(false);
  options.duration_s = 120.0;
  options.realism.upside_down.on = true;
  SimulatedLog log = simulate_log("office", 2, options);
  std::erase_if(log.messages, [](const SensorMessage& message) {
    return std::holds_alternative<ImuSample>(message);
  });
  const MapResult result = map_of(log);
  EXPECT_TRUE(result.calibration.turns_opposite);
  EXPECT_FALSE(result.calibration.laser_is_mirrored);
}

TEST(CalibrationSimulated, ASweepThatNobodyToldIsFoundAndTheMapMadeAnew) {
  SimulationOptions options = office_options(false);
  options.duration_s = 150.0;
  options.realism.sweep.on = true;
  const SimulatedLog log = simulate_log("office", 3, options);
  const MapResult first = map_of(log);
  const Calibration& found = first.calibration;
  ASSERT_TRUE(found.sweep_is_off);
  EXPECT_NEAR(found.sweep_s.value, 0.075, 0.002);
  const MapResult second = map_of_corrected(log, found);
  EXPECT_LT(ate_rmse_m(second.trajectory, log), 0.5 * ate_rmse_m(first.trajectory, log));
  EXPECT_LT(heading_error_rad(second, log), 0.5 * heading_error_rad(first, log));
  EXPECT_FALSE(second.calibration.mount_is_off());
  EXPECT_NEAR(second.calibration.lidar_y_m.value, 0.0, 0.005);
  EXPECT_NEAR(second.calibration.laser_delay_s.value, -options.laser.clock_offset_s, 0.002);
}

void expect_same(const Calibration& judged, const Calibration& finished) {
  EXPECT_EQ(judged.beams_are_off(), finished.beams_are_off());
  EXPECT_EQ(judged.laser_is_mirrored, finished.laser_is_mirrored);
  EXPECT_EQ(judged.sweep_s.value, finished.sweep_s.value);
  EXPECT_EQ(judged.sweep_s.sigma, finished.sweep_s.sigma);
  EXPECT_EQ(judged.lidar_yaw_rad.value, finished.lidar_yaw_rad.value);
  EXPECT_EQ(judged.motions, finished.motions);
}

TEST(CalibrationSimulated, BeamsAreJudgedBeforeTheMapIsFinished) {
  SimulationOptions options = office_options(false);
  options.duration_s = 120.0;
  options.realism.sweep.on = true;
  const SimulatedLog log = simulate_log("office", 3, options);
  Mapper mapper(log.robot, {}, {});
  for (const auto& message : log.messages) mapper.add(message);
  const Calibration judged = mapper.judge_robot();
  EXPECT_TRUE(judged.beams_are_off());
  const MapResult asked = mapper.finish();
  expect_same(judged, asked.calibration);

  const MapResult unasked = map_of(log);
  ASSERT_EQ(asked.trajectory.size(), unasked.trajectory.size());
  for (std::size_t i = 0; i < asked.trajectory.size(); ++i)
    ASSERT_EQ(asked.trajectory.poses()[i].pose, unasked.trajectory.poses()[i].pose) << i;
}

TEST(CalibrationSimulated, ASweepThatTheLogTellsIsNotTouched) {
  SimulationOptions options = office_options(false);
  options.duration_s = 120.0;
  const MapResult result = map_of(simulate_log("office", 3, options));
  EXPECT_FALSE(result.calibration.beams_are_off());
  EXPECT_FALSE(result.calibration.sweep_s.observable);
}

}  // namespace
}  // namespace loopstone::test
