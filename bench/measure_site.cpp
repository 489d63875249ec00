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
  return {.map_T_box = map_T_box, .length_m = 0.6, .width_m = 0.1, .is_wall = true};
}

/// As seen from where its drives begin: the frame of the site.
World from_its_start(World world) {
  const Pose2 start_T_map = world.map_T_start.inverse();
  for (Box& box : world.plan.boxes) box.map_T_box = start_T_map * box.map_T_box;
  for (Segment& surface : world.plan.surfaces)
    surface = {start_T_map * surface.from, start_T_map * surface.to};
  for (Circle& circle : world.plan.circles) circle.centre = start_T_map * circle.centre;
  for (Eigen::Vector2d& place : world.places) place = start_T_map * place;
  world.map_T_start = {};
  return world;
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

/// Of a partition's length, the share along which the map has something within 5 cm of its faces.
double share_there(const OccupancyMap& map, const Box& partition) {
  constexpr int kSteps = 40;
  constexpr int kReach = 2;  // cells: half the thickness, and one more
  int there = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double along_m = partition.length_m * ((i + 0.5) / kSteps - 0.5);
    const Cell at =
        map.log_odds.frame().cell_of(partition.map_T_box * Eigen::Vector2d(along_m, 0.0));
    bool found = false;
    for (int row = at.row - kReach; row <= at.row + kReach; ++row) {
      for (int column = at.column - kReach; column <= at.column + kReach; ++column) {
        const Cell cell{column, row};
        found = found || (map.observed.value_or(cell, 0) != 0 && map.probability(cell) > 0.65);
      }
    }
    there += found ? 1 : 0;
  }
  return static_cast<double>(there) / kSteps;
}

nlohmann::json checkpoint(const std::string& path, int day, const std::vector<double>& join_s) {
  const Site site(path, SiteAccess::kRead, {2});
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
  after.plan.boxes.push_back(partition(after, 0.7));

  MapOptions options;
  SiteFile::create(path, options_to_toml(list_options(options)));
  nlohmann::json checkpoints = nlohmann::json::array();
  std::vector<double> join_s;
  for (int day = 1; day <= days; ++day) {
    const MappedSession mapped = session_of_day(day < moved_on ? before : after, day, seconds);
    const auto start = Clock::now();
    {  // A connection of its own, as a command has it.
      Site site(path, SiteAccess::kWrite, {2});
      (void)site.add(mapped);
    }
    join_s.push_back(seconds_since(start));
    if (day == 10 || day == days || day % 100 == 0)
      checkpoints.push_back(checkpoint(path, day, join_s));
    if (day % 50 == 0) std::fprintf(stderr, "  day %d\n", day);
  }
  const Site site(path, SiteAccess::kRead, {2});
  const SiteMap map = site.map();
  std::filesystem::create_directories(maps);
  write_ros_map(maps + "/site.yaml", cell_states(map.result.map));
  const World true_now = from_its_start(after);
  write_ros_map(maps + "/true.yaml", true_map(true_now));
  const Box old_wall = from_its_start(before).plan.boxes.back();
  const Box new_wall = true_now.plan.boxes.back();
  const nlohmann::json result{{"checkpoints", checkpoints},
                              {"new_wall_there", share_there(map.result.map, new_wall)},
                              {"old_wall_there", share_there(map.result.map, old_wall)}};
  std::printf("%s\n", result.dump().c_str());
  return 0;
}
