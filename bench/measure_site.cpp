// What a site costs and knows after many days of one building, of which a wall is moved on the way.
//
//   measure_site SITE DAYS MOVED_ON SECONDS MAPS
//
// Each day a robot drives through an office for SECONDS, with noise of its own, and its drive is
// added to SITE, which must not be there yet. From day MOVED_ON on a wall stands elsewhere. Writes
// into the folder MAPS the map of the last day and the true one, in the frame of the site, and to
// standard output a JSON object.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "loopstone/base/option_list.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/formats/robot_file.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/pipeline/site.hpp"
#include "loopstone/sensor/log_digest.hpp"
#include "loopstone/simulation/simulate.hpp"
#include "loopstone/slam/mapper.hpp"

using namespace loopstone;

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// A partition that stands across the first room's free side, two metres before the robot's start.
Box partition(const World& world, double aside_m) {
  const Pose2 map_T_box = world.map_T_start * Pose2{2.5, aside_m, 0.5 * kPi};
  return {.map_T_box = map_T_box, .length_m = 1.0, .width_m = 0.1, .is_wall = true};
}

MappedSession session_of_day(const World& world, int day, double seconds) {
  const RobotModel robot;
  const MapOptions options;
  SimulationOptions simulated{.duration_s = seconds};
  simulated.laser.beams = 361;
  Mapper mapper(robot, options, {2});
  LogDigest digest;
  (void)simulate(world, robot, simulated, static_cast<std::uint64_t>(day),
                 {.message = [&](const SensorMessage& message) {
                   digest.add(message);
                   mapper.add(message);
                 }});
  (void)mapper.judge_robot();
  MappedSession mapped;
  mapped.session.log = "day " + std::to_string(day);
  mapped.session.digest = digest.text();
  mapped.session.begins = Stamp::from_seconds(1.7e9 + 86'400.0 * day);
  mapped.session.robot = robot_to_toml(robot);
  mapped.session.verdict = "good";
  mapped.record =
      std::make_shared<const DriveRecord>(record_of(mapper.save_state().get(), options));
  return mapped;
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values.empty() ? 0.0 : values[values.size() / 2];
}

nlohmann::json checkpoint(const Site& site, int day, const std::vector<double>& join_s) {
  int joined = 0;
  int retired = 0;
  for (const SiteSession& session : site.sessions()) {
    joined += session.status == SessionStatus::kJoined ? 1 : 0;
    retired += session.status == SessionStatus::kRetired ? 1 : 0;
  }
  constexpr std::size_t kLast = 10;
  const std::size_t first = join_s.size() - std::min(join_s.size(), kLast);
  return {{"day", day},
          {"bytes", site.file().bytes()},
          {"joined", joined},
          {"retired", retired},
          {"join_s", median({join_s.begin() + static_cast<std::ptrdiff_t>(first), join_s.end()})}};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 6) {
    std::fprintf(stderr, "usage: measure_site SITE DAYS MOVED_ON SECONDS MAPS\n");
    return 2;
  }
  const std::string path = argv[1];
  const int days = std::atoi(argv[2]);
  const int moved_on = std::atoi(argv[3]);
  const double seconds = std::atof(argv[4]);
  const std::string maps = argv[5];
  World before = make_world("office", 1);
  World after = before;
  before.plan.boxes.push_back(partition(before, 0.0));
  after.plan.boxes.push_back(partition(after, 1.2));

  MapOptions options;
  SiteFile::create(path, options_to_toml(list_options(options)));
  nlohmann::json result = nlohmann::json::array();
  std::vector<double> join_s;
  for (int day = 1; day <= days; ++day) {
    const MappedSession mapped = session_of_day(day < moved_on ? before : after, day, seconds);
    // A connection of its own, as a command has it: what is written is in the file then.
    Site site(path, SiteAccess::kWrite, {2});
    const auto start = Clock::now();
    (void)site.add(mapped);
    join_s.push_back(seconds_since(start));
    if (day == 10 || day == days || day % 100 == 0 || day == moved_on)
      result.push_back(checkpoint(site, day, join_s));
    if (day % 50 == 0) std::fprintf(stderr, "  day %d\n", day);
  }
  const Site site(path, SiteAccess::kRead, {2});
  const SiteMap map = site.map();
  std::filesystem::create_directories(maps);
  write_ros_map(maps + "/site.yaml", cell_states(map.result.map));
  // The frame of the site is where its oldest session began.
  after = moved(std::move(after), after.map_T_start.inverse());
  write_ros_map(maps + "/true.yaml", true_map(after));
  std::printf("%s\n", result.dump().c_str());
  return 0;
}
