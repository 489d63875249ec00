// Dead reckoning from wheel counts and gyro, reading by reading, compared with the truth.
#include <cmath>
#include <cstdio>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/odometry/odometer.hpp"
#include "loopstone/simulation/simulate.hpp"

using namespace loopstone;

int main() {
  // A robot drives through an office for two minutes; its readings arrive one at a time, as from a
  // log.
  const World world = make_world("office", 1);
  const RobotModel robot;
  SimulationOptions options;
  options.duration_s = 120.0;
  options.laser.beams = 2;  // the laser matters only as a clock here

  Odometer odometer(robot.wheels);
  SimulationSink sink;
  sink.message = [&](const SensorMessage& message) {
    if (const auto* ticks = std::get_if<WheelTicks>(&message)) odometer.add(*ticks);
    if (const auto* sample = std::get_if<ImuSample>(&message)) odometer.add(*sample);
  };
  StampedPose2 last;
  sink.truth = [&](const StampedPose2& map_T_robot) { last = map_T_robot; };
  const SimulationSummary drive = simulate(world, robot, options, 1, sink);
  odometer.finish();

  // Dead reckoning starts at the origin, the world's map has an origin of its own.
  const auto known = odometer.pose_at(last.stamp);
  if (!known) return 1;
  const Pose2 estimate = world.map_T_start * known->pose;
  const double error_m = std::hypot(estimate.x - last.pose.x, estimate.y - last.pose.y);
  const double error_deg = degrees(std::abs(wrap_angle(estimate.yaw - last.pose.yaw)));

  std::printf("drove %.1f m in %.0f s\n", drive.route_length_m, drive.duration_s);
  std::printf("gyro bias learned at standstill: %.4f rad/s\n", odometer.gyro_bias_rad_s());
  std::printf("at the end: %.2f m and %.1f deg from the truth\n", error_m, error_deg);
  std::printf("believed:   %.2f m and %.1f deg (one standard deviation)\n",
              std::sqrt(known->covariance(0, 0) + known->covariance(1, 1)),
              degrees(std::sqrt(known->covariance(2, 2))));
  return error_m < 0.1 * drive.route_length_m ? 0 : 1;
}
