#include "loopstone/pipeline/log_localization.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_files.hpp"

namespace loopstone {

namespace {

/// That no place was found is a result; that no scan could be used is not.
void require_usable_scans(const LocalizationResult& result, const std::string& path) {
  if (result.scans == 0 || result.scans_dropped < result.scans) return;
  throw DataError({path}, fmt::format("none of its {} scans has enough returns to tell a place; "
                                      "`loopstone info` shows what is wrong with them",
                                      result.scans));
}

}  // namespace

LogLocalization localize_log(const LogSource& source, LogReader& reader, const DrivenRobot& robot,
                             const LocalizationMap& map, const LocalizationOptions& options,
                             const std::optional<InitialPose>& initial, std::uint64_t seed,
                             const LogCut& cut, Threads threads, const ReadingWatch& watch) {
  const LogFiles files(source.path);
  CutLog log(reader, cut, robot.mounts_from_log, "localising", watch);
  Localizer localizer(map, robot.model, options, initial, seed, threads);
  while (const auto message = log.next()) localizer.add(*message);

  LogLocalization done{.result = localizer.finish()};
  done.result.complete = done.result.complete && !log.interrupted();
  done.log = log.judge(source.path);
  require_usable_scans(done.result, source.path);
  std::vector<std::string> warnings = warnings_of(done.log);
  const auto append = [&warnings](const std::vector<std::string>& more) {
    warnings.insert(warnings.end(), more.begin(), more.end());
  };
  append(robot.warnings);
  append(done.result.warnings);
  append(files.changes());
  done.result.warnings = std::move(warnings);
  return done;
}

}  // namespace loopstone
