// Where is the robot on a known map, and how sure is that? Records a drive in a simulated office,
// forgets where it began,
// and finds the robot again:  example_07_localize
#include <cmath>
#include <cstdio>
#include <vector>

#include "loopstone/formats/ros_map.hpp"
#include "loopstone/localization/localizer.hpp"
#include "loopstone/report/localization_outputs.hpp"
#include "loopstone/simulation/simulate.hpp"

using namespace loopstone;

int main() {
  SimulationOptions drive;
  drive.duration_s = 30.0;
  drive.laser.beams = 361;
  const World office = make_world("office", 1);
  std::vector<SensorMessage> log;
  Trajectory truth;
  SimulationSink sink;
  sink.message = [&](SensorMessage message) { log.push_back(std::move(message)); };
  sink.truth = [&](const StampedPose2& pose) { truth.append(pose.stamp, pose.pose); };
  simulate(office, RobotModel{}, drive, 1, sink);

  const LocalizationMap map(true_map(office));  // or read_ros_map("map.yaml")
  Localizer localizer(map, RobotModel{}, LocalizationOptions{}, {}, 1);  // {}: from anywhere
  int scans = 0;
  for (const SensorMessage& message : log) {
    localizer.add(message);
    while (const auto estimate = localizer.next_update()) {
      if (scans++ % 50 != 0) continue;
      std::printf("(%6.2f, %6.2f) m, right to %3.0f %%: %s\n", estimate->map_T_robot.x,
                  estimate->map_T_robot.y, 100.0 * estimate->probability,
                  to_string(estimate->state).data());
    }
  }
  const LocalizationResult result = localizer.finish();
  if (result.estimates.empty()) return 1;

  const LocalizationEstimate& last = result.estimates.back();
  const Pose2 right = truth.at_clamped(last.stamp).value();
  const double error_m = std::hypot(last.map_T_robot.x - right.x, last.map_T_robot.y - right.y);
  std::printf("after %.1f m, %.3f m off the truth; open localized/report.html\n", last.travelled_m,
              error_m);
  LocalizationRunInfo info;
  info.run.log_path = "a drive in the office";
  info.run.force = true;
  info.map_path = "the office";
  write_localization_outputs(result, map.occupancy(), info, "localized");
  return error_m < 0.2 ? 0 : 1;
}
