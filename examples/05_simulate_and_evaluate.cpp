// How good is a map? Simulate, where the truth is known, and compare: odometry alone, matching
// alone, loops closed.
#include <cstdio>
#include <vector>

#include "loopstone/evaluation/trajectory_error.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/simulation/simulate.hpp"
#include "loopstone/slam/mapper.hpp"

using namespace loopstone;

namespace {

AbsoluteError report(const char* name, const Trajectory& estimate, const Trajectory& truth) {
  AbsoluteError error = absolute_error(estimate, truth, Alignment::kSe2);
  std::printf("%-16s %8.3f m rmse %8.3f m max %8.2f deg rmse\n", name, error.translation_m.rmse,
              error.translation_m.max, degrees(error.rotation_rad.rmse));
  return error;
}

}  // namespace

int main() {
  // A laser as on many older robots: 180 degrees, one beam a degree.
  SimulationOptions options;
  options.duration_s = 150.0;
  options.laser = {.rate_hz = 5.0, .beams = 181, .fov_rad = kPi};

  std::vector<SensorMessage> messages;
  Trajectory truth;
  SimulationSink sink;
  sink.message = [&](SensorMessage message) { messages.push_back(std::move(message)); };
  sink.truth = [&](const StampedPose2& pose) { truth.append(pose.stamp, pose.pose); };
  const SimulationSummary drive = simulate(make_world("office", 2), RobotModel{}, options, 2, sink);
  std::printf("%lld scans, %.0f m\n", static_cast<long long>(drive.scans), drive.route_length_m);

  const auto map_with = [&](bool loop_closure) {
    MapOptions map_options;
    map_options.loop_closure = loop_closure;
    Mapper mapper(RobotModel{}, map_options);
    for (const SensorMessage& message : messages) mapper.add(message);
    return mapper.finish();
  };
  const MapResult matched = map_with(false);
  const MapResult closed = map_with(true);

  const AbsoluteError odometry = report("odometry", closed.odometry, truth);
  report("matching alone", matched.trajectory, truth);
  const AbsoluteError loopstone = report("loops closed", closed.trajectory, truth);
  return loopstone.translation_m.rmse < odometry.translation_m.rmse ? 0 : 1;
}
