// How far did the robot move between two scans? align() picks the matcher that suits what is
// aligned: here a search about the guess and Gauss-Newton, without any odometry.
#include <cmath>
#include <cstdio>
#include <vector>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/registration/align.hpp"
#include "loopstone/simulation/simulate.hpp"

using namespace loopstone;

int main() {
  const World world = make_world("office", 1);
  const RobotModel robot;
  SimulationOptions options;
  options.duration_s = 10.0;

  std::vector<LaserScan> scans;
  std::vector<Pose2> map_T_robot;
  SimulationSink sink;
  sink.message = [&](const SensorMessage& message) {
    if (const auto* scan = std::get_if<LaserScan>(&message)) scans.push_back(*scan);
  };
  sink.truth = [&](const StampedPose2& pose) { map_T_robot.push_back(pose.pose); };
  simulate(world, robot, options, 1, sink);

  // Two scans 0.3 s apart, each with where the laser sits on the robot.
  const std::size_t target = 60;
  const std::size_t source = 63;
  const auto of_robot = [&](std::size_t i) {
    return RobotScan{scans[i], mount_of(scans[i], robot)};
  };
  const AlignResult<2> aligned = align(of_robot(source), of_robot(target));
  const MatchResult& match = aligned.match;

  const Pose2 truth = map_T_robot[target].inverse() * map_T_robot[source];
  const Pose2 error = truth.inverse() * match.target_T_source;
  std::printf("status      %s by '%s' after %d iterations, %.0f %% of the scan explained\n",
              to_string(match.status).data(), aligned.method.c_str(), match.iterations,
              100.0 * match.score);
  std::printf("estimate    x %.4f m  y %.4f m  yaw %.3f deg\n", match.target_T_source.x,
              match.target_T_source.y, degrees(match.target_T_source.yaw));
  std::printf("truth       x %.4f m  y %.4f m  yaw %.3f deg\n", truth.x, truth.y,
              degrees(truth.yaw));
  std::printf("error       %.1f mm, %.3f deg\n", 1000.0 * std::hypot(error.x, error.y),
              degrees(error.yaw));
  std::printf("believed    %.1f mm, %.3f deg (one standard deviation)\n",
              1000.0 * std::sqrt(match.covariance(0, 0) + match.covariance(1, 1)),
              degrees(std::sqrt(match.covariance(2, 2))));
  return match.status == MatchStatus::kConverged && std::hypot(error.x, error.y) < 0.03 ? 0 : 1;
}
