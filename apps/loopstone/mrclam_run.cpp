#include "mrclam_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "loopstone/base/error.hpp"

namespace loopstone::app {

MrclamLog read_mrclam_run(const std::string& path, const LogFlags& flags,
                          const SightingNoise& noise, const AppContext& context) {
  ProblemPrinter print_problem(context);
  MrclamLog log =
      read_mrclam_log(path,
                      {.range_sigma_m = noise.range_sigma_m,
                       .bearing_sigma_rad = noise.bearing_sigma_rad,
                       .strict = flags.strict,
                       .on_problem = [&](const LogProblem& problem) { print_problem(problem); }},
                      context.memory());
  context.note(
      fmt::format("{}: robot {}, {} readings of landmarks; {} sightings of other robots are left "
                  "out",
                  path, log.robot, log.readings.size(), log.of_robots));
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

}  // namespace loopstone::app
