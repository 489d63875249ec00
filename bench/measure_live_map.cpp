// How far the map that exists while a robot drives is from the finished one, and what it costs.
//
//   measure_live_map LOG SECONDS [THREADS]
//
// The log is read as fast as it goes; after every SECONDS of the recording the live map is
// refreshed, and at the end until it shows everything. Writes one JSON object.

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/slam/live_map.hpp"
#include "loopstone/slam/mapper.hpp"

using namespace loopstone;

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Of the cells that the finished map knows to be free or occupied.
struct Agreement {
  std::int64_t cells = 0;
  std::int64_t equal = 0;
  std::int64_t opposite = 0;  ///< free on one, occupied on the other
};

Agreement compare(const OccupancyMap& live, const OccupancyMap& finished) {
  const CellStates a = cell_states(live);
  const CellStates b = cell_states(finished);
  const GridFrame& frame = b.frame();
  Agreement agreement;
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      const Cell cell{column, row};
      if (b[cell] == kUnknownCell) continue;
      ++agreement.cells;
      const Cell other = a.frame().cell_of(frame.centre_of(cell));
      if (!a.frame().contains(other) || a[other] == kUnknownCell) continue;
      ++(a[other] == b[cell] ? agreement.equal : agreement.opposite);
    }
  }
  return agreement;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "measure_live_map LOG SECONDS [THREADS]\n");
    return 2;
  }
  const double every_s = std::atof(argv[2]);
  const auto log = open_log(argv[1]);
  const RobotModel robot = log->robot(RobotModel{});
  const MapOptions options;
  Mapper mapper(robot, options, Threads{argc > 3 ? std::atoi(argv[3]) : 0});
  LiveMap live(options.map, robot.footprint_radius_m);
  std::vector<double> refresh_s;
  std::size_t in_a_row = 0;  // refreshes that did not suffice
  std::size_t behind = 0;    // at most
  std::optional<Stamp> due;
  const auto refresh = [&] {
    const auto start = Clock::now();
    (void)live.refresh(mapper.snapshot());
    refresh_s.push_back(seconds_since(start));
    in_a_row = live.is_current() ? 0 : in_a_row + 1;
    behind = std::max(behind, in_a_row);
  };
  while (const auto message = log->next()) {
    mapper.add(*message);
    while (const auto update = mapper.next_update()) {
      if (!due) due = update->stamp;
      if (update->stamp < *due) continue;
      refresh();
      due = update->stamp + Duration{static_cast<std::int64_t>(1e9 * every_s)};
    }
  }
  do {
    refresh();
  } while (!live.is_current());
  const OccupancyMap so_far = live.map();
  const MapResult result = mapper.finish();
  const Agreement agreement = compare(so_far, result.map);
  std::sort(refresh_s.begin(), refresh_s.end());
  const auto share = [&](std::int64_t count) {
    return static_cast<double>(count) /
           static_cast<double>(std::max<std::int64_t>(agreement.cells, 1));
  };
  const nlohmann::json json{{"scans", result.statistics.scans},
                            {"refreshes", refresh_s.size()},
                            {"refresh_median_s", refresh_s[refresh_s.size() / 2]},
                            {"refresh_worst_s", refresh_s.back()},
                            {"refreshes_behind", behind},
                            {"tiles", live.tiles_since(0).size()},
                            {"cells", agreement.cells},
                            {"equal_share", share(agreement.equal)},
                            {"opposite_share", share(agreement.opposite)}};
  std::printf("%s\n", json.dump().c_str());
  return 0;
}
