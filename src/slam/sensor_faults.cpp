#include "slam/sensor_faults.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "slam/run_clock.hpp"

namespace loopstone {

namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
/// So many faults of a kind are told one by one; of the rest their number.
constexpr std::size_t kTold = 8;

std::string moved(const LaserEpisode& episode) {
  if (!(episode.odometry_m > 0.0 || episode.odometry_rad > 0.0)) return {};
  return fmt::format(" while odometry went {} and turned {:.0f} deg",
                     readable_metres(episode.odometry_m), kDegrees * episode.odometry_rad);
}

std::string text_of(const LaserEpisode& episode, const RunClock& clock) {
  const std::string when = clock.span(episode.from, episode.to) + moved(episode);
  const std::string name =
      episode.lidar == 0 ? "the laser" : fmt::format("laser {}", episode.lidar + 1);
  const std::string left_out = fmt::format("; these {} scans were not used", episode.scans);
  switch (episode.fault) {
    case LaserFault::kBlocked:
      return name + " was blocked " + when + ": nearly all returns came from within 35 cm of it" +
             left_out;
    case LaserFault::kFrozen:
      return name + " was frozen " + when + ": it repeated one scan to the last bit" + left_out;
    case LaserFault::kCovered:
      return fmt::format(
          "{} was covered in part, or people stood about it, {}: many of its beams ended around it "
          "where there is nothing on the map; they were left out of {} scans",
          name, when, episode.scans);
  }
  return {};
}

void add_repeats(const MapResult& result, std::vector<std::string>& faults) {
  if (result.statistics.scans_repeated >= kSensorFaults.many_repeats) {
    faults.push_back(fmt::format(
        "{} scans in a row are the same to the last bit: the robot stood still, or the laser was "
        "frozen; without odometry nothing tells which",
        result.statistics.scans_repeated + 1));
  }
}

std::string likelier(const std::optional<double>& wheels_with_gyro) {
  if (wheels_with_gyro && *wheels_with_gyro > kSensorFaults.same_correlation)
    return "wheels and gyro agree with one another, so the laser is the likelier one";
  if (wheels_with_gyro && *wheels_with_gyro < -kSensorFaults.same_correlation)
    return "wheels and gyro contradict one another too, so the gyro is the likelier one";
  return "the data can't tell which";
}

void add_contradictions(const MapResult& result, const RunClock& clock,
                        std::vector<std::string>& faults) {
  for (const OdometryEpisode& episode : result.odometry_episodes) {
    const std::string when = clock.span(episode.from, episode.to);
    if (episode.fault == OdometryFault::kMirrored && episode.part == OdometryPart::kRotation) {
      faults.push_back("laser and odometry turn opposite ways " + when +
                       ": the laser's beams are listed in the wrong order (does it hang upside "
                       "down?), or odometry's heading has the wrong sign; " +
                       likelier(result.statistics.wheels_with_gyro) +
                       ". The map follows the laser: if that is wrong, the map is a mirror image");
    }
    if (episode.fault == OdometryFault::kSpinning && episode.part == OdometryPart::kTranslation) {
      faults.push_back("odometry drives " + when +
                       " while the laser sees nothing move: the wheels slip, or the laser is "
                       "covered by something that travels with it; the data can't tell which");
    }
  }
}

void add_calibration(const MapResult& result, std::vector<std::string>& faults) {
  const MapStatistics& s = result.statistics;
  if (result.calibration.mirror_is_in_doubt && result.calibration.beams_corrected) {
    faults.emplace_back(
        "laser and odometry turn opposite ways and no gyro says which is right: the map takes the "
        "laser for one upside down; if odometry's heading has the wrong sign, it is a mirror "
        "image");
  }
  const double scale = s.odometry_translation_scale;
  if (scale > 0.0 && std::abs(scale - 1.0) > kSensorFaults.scale_off) {
    faults.push_back(fmt::format(
        "odometry goes {:.2f} times as far as the laser sees: the wheels' size is wrong, or the "
        "laser's ranges are; the data can't tell which. The map has the laser's scale",
        scale));
  }
  if (result.calibration.is_corrected) return;
  if (s.laser_heading_offset_rad &&
      std::abs(*s.laser_heading_offset_rad) > kSensorFaults.mount_off_deg / kDegrees) {
    const double offset = kDegrees * *s.laser_heading_offset_rad;
    faults.push_back(fmt::format(
        "the laser sees the robot go {:.1f} deg to the {} while odometry goes straight ahead: the "
        "laser is mounted {:.1f} deg farther to the {} than its mount says, or odometry's axes are",
        std::abs(offset), offset > 0.0 ? "left" : "right", std::abs(offset),
        offset > 0.0 ? "right" : "left"));
  }
}

}  // namespace

std::vector<std::string> sensor_faults(const MapResult& result) {
  std::vector<std::string> faults;
  if (result.trajectory.empty()) return faults;
  const RunClock clock(result.trajectory.front().stamp);
  add_repeats(result, faults);
  add_contradictions(result, clock, faults);
  add_calibration(result, faults);
  return faults;
}

std::vector<std::string> unused_scans(const MapResult& result) {
  std::vector<std::string> faults;
  if (result.trajectory.empty()) return faults;
  const RunClock clock(result.trajectory.front().stamp);
  std::size_t told = 0;
  for (const LaserEpisode& episode : result.laser_episodes) {
    if ((episode.to - episode.from).seconds() < kSensorFaults.brief_s || ++told > kTold) continue;
    faults.push_back(text_of(episode, clock));
  }
  if (told > kTold)
    faults.push_back(
        fmt::format("{} more times the laser was blocked, covered or frozen", told - kTold));
  return faults;
}

}  // namespace loopstone
