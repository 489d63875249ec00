#include "support/simulated_log.hpp"

#include <utility>

namespace loopstone::test {

std::vector<LaserScan> SimulatedLog::scans() const {
  std::vector<LaserScan> list;
  for (const SensorMessage& message : messages) {
    if (const auto* scan = std::get_if<LaserScan>(&message)) list.push_back(*scan);
  }
  return list;
}

SimulatedLog simulate_log(const std::string& world, std::uint64_t seed,
                          const SimulationOptions& options, const RobotModel& robot) {
  SimulatedLog log;
  RealismRecord of_world;
  log.world = real_world(make_world(world, seed), options.realism, seed, of_world);
  log.robot = robot;
  SimulationSink sink;
  sink.message = [&](SensorMessage message) { log.messages.push_back(std::move(message)); };
  sink.truth = [&](const StampedPose2& pose) { log.truth.append(pose.stamp, pose.pose); };
  log.summary = simulate(log.world, robot, options, seed, sink);
  auto& facts = log.summary.realism.facts;
  facts.insert(facts.begin(), of_world.facts.begin(), of_world.facts.end());
  return log;
}

SimulationOptions noise_free(SimulationOptions options) {
  options.laser.noise_m = 0.0;
  options.laser.dropout_probability = 0.0;
  options.laser.clock_offset_s = 0.0;
  options.wheels.scale_error = 0.0;
  options.wheels.imbalance = 0.0;
  options.wheels.turn_slip = 0.0;
  options.wheels.slip_m_per_sqrt_m = 0.0;
  options.imu.bias_rad_s = 0.0;
  options.imu.bias_drift_rad_s = 0.0;
  options.imu.noise_rad_s = 0.0;
  options.imu.acceleration_noise_m_s2 = 0.0;
  return options;
}

}  // namespace loopstone::test
