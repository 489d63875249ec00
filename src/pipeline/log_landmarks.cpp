#include "loopstone/pipeline/log_landmarks.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_files.hpp"
#include "loopstone/localization/landmark_tracker.hpp"

namespace loopstone {

namespace {

/// Reflectors need intensities, and enough of them.
void require_reflectors(const LandmarkTracker& tracker, const std::string& path) {
  if (tracker.scans_with_intensities() == 0) {
    throw DataError({path},
                    "its scans have no intensities, by which reflectors are told; MCAP, ROS 1 bags "
                    "and rosbag2 hold them where the driver tells them");
  }
  if (tracker.observations() == 0) {
    throw DataError({path},
                    "no beam is bright enough to be one on a reflector; a lower "
                    "reflectors.brightness (--reflector-threshold) takes fainter ones");
  }
}

}  // namespace

MapLandmarks landmarks_of(const ReflectorMapper& reflectors, const MapResult& result) {
  MapLandmarks found{.mapping = reflectors.settle(result)};
  if (!result.complete) return found;
  if (reflectors.scans_with_intensities() == 0) {
    found.failure =
        "no landmarks: the scans have no intensities, by which reflectors are told; MCAP, ROS 1 "
        "bags and rosbag2 hold them where the driver tells them";
  } else if (found.mapping.figures.observations == 0) {
    found.failure =
        "no landmarks: no beam is bright enough to be one on a reflector; a lower "
        "landmarks.reflectors.brightness (--reflector-threshold) takes fainter ones";
  } else if (found.mapping.landmarks.empty()) {
    found.warning =
        "no landmarks: nothing bright was seen often enough, from places far enough apart; see "
        "landmarks.sightings_min and landmarks.baseline_min_m";
  }
  return found;
}

LogLocalization localize_by_reflectors(const LogSource& source, LogReader& reader,
                                       const LandmarkMap& landmarks,
                                       const LandmarkTrackingOptions& options,
                                       const std::optional<InitialPose>& initial, const LogCut& cut,
                                       const ReadingWatch& watch) {
  const LogFiles files(source.path);
  CutLog log(reader, cut, source.mounts_from_log(), "localising", watch);
  LandmarkTracker tracker(landmarks, source.robot_of(reader), options, initial);
  while (const auto message = log.next()) tracker.add(*message);

  LogLocalization done{.result = tracker.finish()};
  done.result.complete = done.result.complete && !log.interrupted();
  done.log = log.judge(source.path);
  if (!log.interrupted()) require_reflectors(tracker, source.path);
  std::vector<std::string> warnings = warnings_of(done.log);
  const auto append = [&warnings](const std::vector<std::string>& more) {
    warnings.insert(warnings.end(), more.begin(), more.end());
  };
  append(done.result.warnings);
  append(files.changes());
  done.result.warnings = std::move(warnings);
  return done;
}

MrclamLog read_mrclam_drive(const std::string& path, MrclamOptions how, const SightingNoise& noise,
                            const MemoryBudget& budget) {
  how.range_sigma_m = noise.range_sigma_m;
  how.bearing_sigma_rad = noise.bearing_sigma_rad;
  MrclamLog log = read_mrclam_log(path, how, budget);
  if (log.readings.empty()) throw DataError({path}, "none of what was seen is a landmark");
  return log;
}

std::vector<LandmarkReading> readings_within(const MrclamLog& log, const LogCut& cut,
                                             bool nameless) {
  const Stamp first = std::min(log.odometry.front().stamp, log.readings.front().stamp);
  std::vector<LandmarkReading> readings;
  for (const LandmarkReading& reading : log.readings) {
    const double time_s = (reading.stamp - first).seconds();
    if (time_s < cut.start_s) continue;
    if (cut.duration_s > 0.0 && time_s > cut.start_s + cut.duration_s) break;
    if (cut.max_scans > 0 && static_cast<std::int64_t>(readings.size()) == cut.max_scans) break;
    readings.push_back(reading);
    if (!nameless) continue;
    for (LandmarkObservation& seen : readings.back().observations) seen.id.reset();
  }
  return readings;
}

LeftOut left_out_of(const MrclamLog& log) {
  LeftOut left_out;
  left_out.skipped = log.skipped;
  left_out.records_read = static_cast<std::int64_t>(log.odometry.size() + log.readings.size());
  return left_out;
}

LocalizationResult localize_mrclam(const MrclamLog& log,
                                   const std::vector<LandmarkReading>& readings,
                                   const RobotModel& robot, const LandmarkMap& landmarks,
                                   const LandmarkTrackingOptions& options,
                                   const std::optional<InitialPose>& initial,
                                   const std::function<bool()>& stop) {
  LandmarkTracker tracker(landmarks, robot, options, initial);
  // Readings wait in the tracker for odometry of their time.
  for (const LandmarkReading& seen : readings) tracker.add(seen);
  bool stopped = false;
  for (const OdometryPose& pose : log.odometry) {
    stopped = stop && stop();
    if (stopped) break;
    tracker.add(pose);
  }
  LocalizationResult result = tracker.finish();
  result.complete = result.complete && !stopped;
  return result;
}

}  // namespace loopstone
