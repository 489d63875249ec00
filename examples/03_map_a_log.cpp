// From a log to a trajectory and a map that ROS can load:  example_03_map_a_log [LOG]
// Without a log it records one itself, in a simulated office.
#include <cstdio>
#include <string>

#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/pipeline/log_mapping.hpp"
#include "loopstone/simulation/simulate.hpp"

using namespace loopstone;

namespace {

void record(const char* path) {
  SimulationOptions options;
  options.duration_s = 40.0;
  options.laser.beams = 361;
  const auto writer = create_log(path, "ucsd", RobotModel{});
  SimulationSink sink;
  sink.message = [&](const SensorMessage& message) { writer->write(message); };
  simulate(make_world("office", 1), RobotModel{}, options, 1, sink);
  writer->finish();
}

}  // namespace

int main(int argc, char** argv) {
  const char* const path = argc > 1 ? argv[1] : "recorded";
  if (argc < 2) record(path);

  const LogMap made = map_log({.path = path});  // finds out the format by itself
  const MapResult& result = made.result;
  for (const std::string& warning : result.warnings) std::printf("warning: %s\n", warning.c_str());
  write_tum("trajectory.tum", result.trajectory);
  write_ros_map("map.yaml", cell_states(result.map));  // and map.pgm

  const MapStatistics& statistics = result.statistics;
  const GridFrame& frame = result.map.log_odds.frame();
  std::printf("%s: %lld scans, %.1f m\n", path, static_cast<long long>(statistics.scans),
              statistics.path_length_m);
  std::printf("%lld key scans in %lld submaps, %lld loop closures\n",
              static_cast<long long>(statistics.key_scans),
              static_cast<long long>(statistics.submaps),
              static_cast<long long>(statistics.loop_closures_accepted));
  std::printf("map.yaml: %d x %d cells of %.2f m\n", frame.columns, frame.rows, frame.resolution);
  return statistics.scans > 0 ? 0 : 1;
}
