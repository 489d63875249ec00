// An emulated laser scanner that drives through a simulated building: prints its address and
// serves until the drive is over or it is killed.
//
//   emulated_scanner scip|rplidar [--world office] [--seed 1] [--speed 1] [--port 0]
//                    [--seconds 0] [--disconnect-after S]
//
// --speed 4: the robot drives four times as fast, and the scanner turns four times as fast, so that
// scans lie as far apart as at 1. --seconds: of serving; 0: as long as the drive takes.
// --disconnect-after: cuts the line once, so many seconds after it began to measure.

#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>

#include "loopstone/simulation/drive.hpp"
#include "loopstone/simulation/surface_index.hpp"
#include "loopstone/simulation/world.hpp"
#include "support/emulated_rplidar.hpp"
#include "support/emulated_scip.hpp"

namespace loopstone {
namespace {

using Flags = std::map<std::string, std::string>;

constexpr double kRobotRadiusM = 0.25;

Flags flags_of(int argc, char** argv) {
  Flags flags{{"--world", "office"}, {"--seed", "1"},    {"--speed", "1"},
              {"--port", "0"},       {"--seconds", "0"}, {"--disconnect-after", "0"}};
  if (argc < 2 || argc % 2 != 0)
    throw std::invalid_argument("emulated_scanner scip|rplidar [--flag value]...");
  for (int i = 2; i + 1 < argc; i += 2) {
    const auto flag = flags.find(argv[i]);
    if (flag == flags.end()) throw std::invalid_argument(std::string("no flag ") + argv[i]);
    flag->second = argv[i + 1];
  }
  return flags;
}

double number(const Flags& flags, const std::string& name) {
  const std::string& text = flags.at(name);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || value < 0.0)
    throw std::invalid_argument(name + ": " + text + " is no number");
  return value;
}

/// What a scanner at the centre of a robot sees that drives through a world.
test::EmulatedRoom room_of(const std::shared_ptr<const World>& world,
                           const std::shared_ptr<const Drive>& drive, double speed) {
  const auto index = std::make_shared<const SurfaceIndex>(world->plan);
  return {.range_m =
              [=](double time_s, double angle_rad) {
                constexpr double kFarthestM = 100.0;
                const Pose2 pose = drive->pose_at(time_s * speed);
                const double heading = pose.yaw + angle_rad;
                return index->cast(pose.translation(), {std::cos(heading), std::sin(heading)},
                                   kFarthestM);
              },
          .brightness = [](double) { return 40; }};
}

void serve(const std::string& address, double seconds) {
  std::printf("%s\n", address.c_str());
  std::fflush(stdout);
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

void run(const std::string& kind, const Flags& flags) {
  const double speed = number(flags, "--speed");
  const auto world = std::make_shared<const World>(
      make_world(flags.at("--world"), static_cast<std::uint64_t>(number(flags, "--seed"))));
  const auto drive = std::make_shared<const Drive>(drive_route(*world, kRobotRadiusM));
  const test::EmulatedRoom room = room_of(world, drive, speed);
  const double seconds =
      number(flags, "--seconds") > 0.0 ? number(flags, "--seconds") : drive->duration_s() / speed;
  const double cut_s = number(flags, "--disconnect-after");
  if (kind == "scip") {
    constexpr double kTurnsASecond = 10.0;
    test::ScipModel model;
    model.longest_mm = 30000;
    model.turns_a_minute = static_cast<int>(std::lround(60.0 * kTurnsASecond * speed));
    test::ScipTroubles troubles;
    if (cut_s > 0.0)
      troubles.disconnects_after = static_cast<int>(std::lround(cut_s * kTurnsASecond * speed));
    const test::EmulatedScip device(room, model, troubles, test::EmulatedLine::Kind::kTcp,
                                    static_cast<std::uint16_t>(number(flags, "--port")));
    serve(device.address(), seconds);
  } else if (kind == "rplidar") {
    test::RplidarModel model;
    model.turns_a_second *= speed;
    model.standard_us /= speed;
    model.express_us /= speed;
    test::RplidarTroubles troubles;
    if (cut_s > 0.0) troubles.is_unplugged_after_s = cut_s;
    const test::EmulatedRplidar device(room, model, troubles);
    serve(device.address(), seconds);
  } else {
    throw std::invalid_argument("'" + kind + "' is neither scip nor rplidar");
  }
}

}  // namespace
}  // namespace loopstone

int main(int argc, char** argv) {
  try {
    const auto flags = loopstone::flags_of(argc, argv);
    loopstone::run(argv[1], flags);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
