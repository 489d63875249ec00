#include "report/fault_summary.hpp"

namespace loopstone {

namespace {

Stamp start_of(const MapResult& result) { return result.trajectory.front().stamp; }

}  // namespace

nlohmann::ordered_json odometry_faults(const MapResult& result) {
  auto list = nlohmann::ordered_json::array();
  if (result.trajectory.empty()) return list;
  const Stamp start = start_of(result);
  for (const OdometryEpisode& episode : result.odometry_episodes) {
    list.push_back({{"part", to_string(episode.part)},
                    {"fault", to_string(episode.fault)},
                    {"from_s", (episode.from - start).seconds()},
                    {"noticed_s", (episode.noticed - start).seconds()},
                    {"to_s", (episode.to - start).seconds()},
                    {"over", episode.over},
                    {"ratio", episode.ratio},
                    {"lag_s", episode.lag_s}});
  }
  return list;
}

nlohmann::ordered_json laser_faults(const MapResult& result) {
  auto list = nlohmann::ordered_json::array();
  if (result.trajectory.empty()) return list;
  const Stamp start = start_of(result);
  for (const LaserEpisode& episode : result.laser_episodes) {
    list.push_back({{"fault", to_string(episode.fault)},
                    {"from_s", (episode.from - start).seconds()},
                    {"to_s", (episode.to - start).seconds()},
                    {"scans", episode.scans},
                    {"odometry_m", episode.odometry_m},
                    {"odometry_rad", episode.odometry_rad}});
  }
  return list;
}

nlohmann::ordered_json path_breaks(const MapResult& result) {
  auto list = nlohmann::ordered_json::array();
  if (result.trajectory.empty()) return list;
  const Stamp start = start_of(result);
  for (const PathBreak& gap : result.breaks) {
    list.push_back({{"from_s", (gap.from - start).seconds()},
                    {"to_s", (gap.to - start).seconds()},
                    {"cause", to_string(gap.cause)},
                    {"bridged_by", to_string(gap.bridge)},
                    {"ends_log", gap.ends_log},
                    {"odometry_m", gap.odometry_m},
                    {"bridge_sigma_m", gap.bridge_sigma_m()},
                    {"closures", gap.closures},
                    {"tie_sigma_m", gap.tie_sigma_m}});
  }
  return list;
}

nlohmann::ordered_json drives_json(const MapResult& result) {
  auto list = nlohmann::ordered_json::array();
  for (const MappedDrive& drive : result.drives) {
    list.push_back({{"first_scan", drive.first_scan},
                    {"scans", drive.scans},
                    {"clock_shift_s", 1e-9 * static_cast<double>(drive.clock_shift_ns.value_or(0))},
                    {"joined", drive.is_joined()},
                    {"closures", drive.closures}});
  }
  return list;
}

}  // namespace loopstone
