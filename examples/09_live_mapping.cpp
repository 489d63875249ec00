// Builds a map while a robot drives: prints where it is and writes the map every ten seconds. The
// robot is a simulated one; a real one hands its messages to Mapper::add() as they come.
#include <cstdio>
#include <variant>

#include "loopstone/formats/ros_map.hpp"
#include "loopstone/simulation/simulate.hpp"
#include "loopstone/slam/live_map.hpp"
#include "loopstone/slam/mapper.hpp"

using namespace loopstone;

int main() {
  const RobotModel robot;
  const MapOptions options;
  Mapper mapper(robot, options, Threads{2});
  LiveMap live(options.map, robot.footprint_radius_m);
  Stamp next_print{};
  Stamp next_map{};

  const auto tell = [&](const MapUpdate& update) {
    for (const MapEvent& event : update.events) {
      const auto* change = std::get_if<ClosureChanged>(&event);
      if (change == nullptr || !change->closure.stands()) continue;
      std::printf("  submap %zu is where submap %zu was\n", change->closure.to_submap.index,
                  change->closure.from_submap.index);
    }
    if (update.stamp >= next_print) {
      const Pose2 map_T_robot = update.map_T_robot();
      std::printf("(%6.2f, %6.2f) m, %s\n", map_T_robot.x, map_T_robot.y,
                  to_string(update.status).data());
      next_print = update.stamp + Duration{2'000'000'000};
    }
    if (update.stamp < next_map) return;
    const std::size_t tiles = live.refresh(mapper.snapshot());
    write_ros_map("live_map.yaml", cell_states(live.map()));
    std::printf("  live_map.yaml: %zu tiles were drawn on\n", tiles);
    next_map = update.stamp + Duration{10'000'000'000};
  };

  SimulationOptions drive;
  drive.duration_s = 60.0;
  SimulationSink sensors;
  sensors.message = [&](const SensorMessage& message) {
    mapper.add(message);
    while (const auto update = mapper.next_update()) tell(*update);
  };
  simulate(make_world("office", 1), robot, drive, 1, sensors);

  const MapResult result = mapper.finish();
  write_ros_map("live_map.yaml", cell_states(result.map));
  std::printf("%lld scans; %s\n", static_cast<long long>(result.statistics.scans),
              result.verdict.sentence.c_str());
  return result.complete ? 0 : 1;
}
