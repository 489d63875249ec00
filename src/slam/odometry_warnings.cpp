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

/// Odometry was late, and is read at its own time since.
bool is_followed(const OdometryEpisode& episode) {
  return episode.fault == OdometryFault::kLagging && episode.over;
}

/// Odometry's clock runs away from the laser's, or is another one. Each time that is found it is so
/// much more.
std::string of_clocks(const std::vector<OdometryEpisode>& episodes, Stamp start) {
  std::vector<const OdometryEpisode*> found;
  double late_s = 0.0;
  double late_first_s = 0.0;
  for (const OdometryEpisode& episode : episodes) {
    if (!is_followed(episode)) continue;
    found.push_back(&episode);
    late_s += episode.lag_s;
    if (found.size() == 1) late_first_s = late_s;
  }
  if (found.empty()) return {};
  const auto told = [&](double seconds, const OdometryEpisode& episode) {
    return number(std::abs(seconds), 2) + " s " + (seconds >= 0.0 ? "late" : "early") + " at " +
           number((episode.noticed - start).seconds(), 0) + " s";
  };
  const std::string runs = found.size() == 1
                               ? "odometry is " + told(late_s, *found.front()) + " beside the laser"
                               : "the clocks of odometry and laser run apart: odometry is " +
                                     told(late_first_s, *found.front()) + ", " +
                                     told(late_s, *found.back());
  return runs + "; from then on it is read so much " + (late_s >= 0.0 ? "later" : "earlier");
}

}  // namespace

std::vector<std::string> odometry_warnings(const MapResult& result) {
  std::vector<std::string> warnings;
  if (result.trajectory.empty()) return warnings;
  const Stamp start = result.trajectory.poses().front().stamp;
  const auto since = [&](Stamp stamp) { return number((stamp - start).seconds(), 0); };
  for (const OdometryEpisode& episode : result.odometry_episodes) {
    // sensor_faults tells of the one, of_clocks() of the other.
    if (is_of_laser_or_odometry(episode) || is_followed(episode)) continue;
    const std::string until = episode.over ? "to " + since(episode.to) + " s" : "to the end";
    warnings.push_back("odometry is wrong from " + since(episode.from) + " s " + until + ": " +
                       what_is_wrong(episode) + "; it was not used from " + since(episode.noticed) +
                       " s on");
  }
  if (std::string clocks = of_clocks(result.odometry_episodes, start); !clocks.empty())
    warnings.push_back(std::move(clocks));
  const MapStatistics& s = result.statistics;
  if (s.odometry_jumps >= kFewestJumps && s.odometry_jumps * kScansPerMistake > s.scans) {
    warnings.push_back("odometry jumped " + std::to_string(s.odometry_jumps) +
                       " times; there the laser alone was believed");
  }
  return warnings;
}

}  // namespace loopstone
