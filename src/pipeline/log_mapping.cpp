#include "loopstone/pipeline/log_mapping.hpp"

#include <memory>
#include <utility>

#include "loopstone/formats/log_files.hpp"
#include "loopstone/slam/robot_correction.hpp"

namespace loopstone {

DriveMapping::DriveMapping(const RobotModel& robot, const MapOptions& options, Threads threads,
                           MappingWatch& watch)
    : given_(robot), robot_(robot), options_(options), threads_(threads), watch_(watch) {}

MapResult DriveMapping::map(const NextMessage& next, bool correct) {
  Mapper mapper(robot_, options_, threads_);
  watch_.begin(mapper, robot_, made_anew_ > 0);
  feed(next, mapper);
  newest_ = {};
  if (correct && !watch_.is_stopped()) newest_ = mapper.judge_robot();
  watch_.finishing(mapper);
  // Who stops wants what there is.
  if (watch_.is_stopped()) newest_ = {};
  MapResult result;
  if (is_bent()) {
    result.calibration = newest_;
  } else {
    result = finish(mapper);
  }
  take_updates(mapper);
  return result;
}

MapResult DriveMapping::map_anew(const NextMessage& next) {
  ++made_anew_;
  found_ = beside(found_, newest_);
  robot_ = corrected_robot(given_, found_);
  MapResult result = map(next, made_anew_ < kMostMadeAnew);
  if (is_bent()) return result;
  result.complete = result.complete && !watch_.is_stopped();
  corrections_ = tell_of_correction(found_, result);
  return result;
}

void DriveMapping::feed(const NextMessage& next, Mapper& mapper) {
  while (const auto message = next()) {
    watch_.add(*message, mapper);
    take_updates(mapper);
    watch_.after(*message, mapper);
  }
  watch_.end(mapper);
}

void DriveMapping::take_updates(Mapper& mapper) {
  while (const auto update = mapper.next_update()) watch_.take(*update, mapper);
}

MapResult DriveMapping::finish(Mapper& mapper) {
  return mapper.finish([this](const Progress& progress) { return watch_.goes_on(progress); });
}

void judge_by_log(const LogSummary& log, const std::vector<std::string>& changes,
                  MapResult& result) {
  const std::vector<std::string> of_log = warnings_of(log);
  result.warnings.insert(result.warnings.begin(), of_log.begin(), of_log.end());
  judge_left_out(result.verdict, log.left_out.share());
  result.warnings.insert(result.warnings.end(), changes.begin(), changes.end());
}

LogMap map_log(const LogSource& source, const MapOptions& options, Threads threads) {
  LogSource own = source;
  own.how.topics.pictures = false;
  const std::unique_ptr<LogReader> reader = own.open_ahead(threads);
  return map_log(own, *reader, {}, options, threads);
}

LogMap map_log(const LogSource& source, LogReader& reader, const LogCut& cut,
               const MapOptions& options, Threads threads, const ReadingWatch& watch,
               MappingWatch* companion) {
  MappingWatch nobody;
  const LogFiles files(source.path);
  MappingWatch& with = companion == nullptr ? nobody : *companion;
  DriveMapping mapping(source.robot_of(reader), options, threads, with);
  CutLog log(reader, cut, source.mounts_from_log(), "mapping", watch);
  LogMap made;
  made.result = mapping.map([&log] { return log.next(); }, with.may_begin_anew());
  made.log = log.judge(source.path);
  bool interrupted = log.interrupted();
  while (mapping.is_bent() && !interrupted) {
    const std::unique_ptr<LogReader> again = source.open_again();
    CutLog second(*again, cut, source.mounts_from_log(), "mapping anew", watch);
    made.result = mapping.map_anew([&second] { return second.next(); });
    interrupted = second.interrupted();
  }
  judge_by_log(made.log, files.changes(), made.result);
  made.result.complete = made.result.complete && !interrupted;
  made.robot = mapping.robot();
  made.corrections = mapping.corrections();
  return made;
}

}  // namespace loopstone
