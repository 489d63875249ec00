#include "slam/odometry_warnings.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <vector>

#include "loopstone/odometry/odometry_check.hpp"

namespace loopstone {

namespace {

/// Three jumps, and more than one in a thousand scans; fewer may be the laser's mistakes.
constexpr std::int64_t kFewestJumps = 3;
constexpr std::int64_t kScansPerMistake = 1000;

std::string number(double value, int digits) { return fmt::format("{:.{}f}", value, digits); }

/// Laser and odometry contradict one another in a way that either may be at fault for.
bool is_of_laser_or_odometry(const OdometryEpisode& episode) {
  return (episode.fault == OdometryFault::kMirrored && episode.part == OdometryPart::kRotation) ||
         (episode.fault == OdometryFault::kSpinning && episode.part == OdometryPart::kTranslation);
}

std::string what_is_wrong(const OdometryEpisode& episode) {
  const bool turns = episode.part == OdometryPart::kRotation;
  const std::string part = turns ? "heading" : "distance";
  switch (episode.fault) {
    case OdometryFault::kStuck:
      return turns ? "its heading stands still while the robot turns"
                   : "it stands still while the robot drives";
    case OdometryFault::kSpinning:
      return turns ? "its heading turns while the robot does not"
                   : "it drives while the robot stands still";
    case OdometryFault::kMirrored:
      return turns ? "it turns the other way" : "it drives the other way";
    case OdometryFault::kScaled:
      return "its " + part + " is " + number(episode.ratio, 2) + " times the true one";
    case OdometryFault::kLagging:
      return episode.lag_s >= 0.0
                 ? "it is " + number(episode.lag_s, 2) + " s late"
                 : "it is " + number(-episode.lag_s, 2) + " s early beside the laser";
    case OdometryFault::kWrong:
      return "its " + part + " disagrees with the laser";
  }
  return {};
}

}  // namespace

std::vector<std::string> odometry_warnings(const MapResult& result) {
  std::vector<std::string> warnings;
  if (result.trajectory.empty()) return warnings;
  const Stamp start = result.trajectory.poses().front().stamp;
  const auto since = [&](Stamp stamp) { return number((stamp - start).seconds(), 0); };
  for (const OdometryEpisode& episode : result.odometry_episodes) {
    if (is_of_laser_or_odometry(episode)) continue;  // sensor_faults tells of it
    const std::string until = episode.over ? "to " + since(episode.to) + " s" : "to the end";
    warnings.push_back("odometry is wrong from " + since(episode.from) + " s " + until + ": " +
                       what_is_wrong(episode) + "; it was not used from " + since(episode.noticed) +
                       " s on");
  }
  const MapStatistics& s = result.statistics;
  if (s.odometry_jumps >= kFewestJumps && s.odometry_jumps * kScansPerMistake > s.scans) {
    warnings.push_back("odometry jumped " + std::to_string(s.odometry_jumps) +
                       " times; there the laser alone was believed");
  }
  return warnings;
}

}  // namespace loopstone
