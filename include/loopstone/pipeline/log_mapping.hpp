#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/base/progress.hpp"
#include "loopstone/formats/log_summary.hpp"
#include "loopstone/pipeline/cut_log.hpp"
#include "loopstone/pipeline/log_source.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/robot_model.hpp"
#include "loopstone/slam/map_options.hpp"
#include "loopstone/slam/map_result.hpp"
#include "loopstone/slam/mapper.hpp"

// How a log becomes a map, as `loopstone map` does it: read and mapped, judged by what is wrong
// with the log, and mapped once more where the drive tells that beams are not as they were said to
// be (slam/robot_correction.hpp).

namespace loopstone {

/// Gives one message after the other, in time order; nothing at the end.
using NextMessage = std::function<std::optional<SensorMessage>()>;

/// Who accompanies a mapping. Does nothing by itself.
class MappingWatch {
 public:
  virtual ~MappingWatch() = default;
  /// Before the first message of a mapping.
  /// \param robot  as it is mapped with
  /// \param anew   what was told before is of no use
  virtual void begin(Mapper& /*mapper*/, const RobotModel& /*robot*/, bool /*anew*/) {}
  /// Gives a message to the mapper.
  virtual void add(const SensorMessage& message, Mapper& mapper) { mapper.add(message); }
  virtual void take(const MapUpdate& /*update*/, Mapper& /*mapper*/) {}
  /// A message and all that it led to were taken.
  virtual void after(const SensorMessage& /*message*/, Mapper& /*mapper*/) {}
  /// All messages were taken.
  virtual void end(Mapper& /*mapper*/) {}
  /// The robot was judged; what is left is to finish the map, or to begin anew.
  virtual void finishing(Mapper& /*mapper*/) {}
  /// Told while the map is finished; false ends that at the next good place.
  virtual bool goes_on(const Progress& /*progress*/) { return true; }
  /// False: the map goes on with drives that can't be had again, so that it is not made anew.
  [[nodiscard]] virtual bool may_begin_anew() const { return true; }
  /// What there is will do: the map is finished as it is.
  [[nodiscard]] virtual bool is_stopped() const { return false; }
};

/// One drive, mapped once, or as often as its robot turns out to be another one.
class DriveMapping {
 public:
  /// \param watch  lives as long as this does
  DriveMapping(const RobotModel& robot, const MapOptions& options, Threads threads,
               MappingWatch& watch);

  /// All that `next` gives.
  /// \param correct  false: the drive is not judged, or can't be had again
  [[nodiscard]] MapResult map(const NextMessage& next, bool correct = true);
  /// The map is bent by beams that are not as they were told: what map() or map_anew() gave has
  /// nothing but that calibration, and the drive is wanted once more.
  [[nodiscard]] bool is_bent() const { return newest_.map_is_bent(); }
  /// The same drive again, with the beams that the last mapping asks for. At most kMostMadeAnew
  /// times: the last of them is the map.
  [[nodiscard]] MapResult map_anew(const NextMessage& next);

  /// That the map was made with.
  [[nodiscard]] const RobotModel& robot() const { return robot_; }
  /// What the map's warnings say of its correction.
  [[nodiscard]] const std::vector<std::string>& corrections() const { return corrections_; }

 private:
  void feed(const NextMessage& next, Mapper& mapper);
  void take_updates(Mapper& mapper);
  [[nodiscard]] MapResult finish(Mapper& mapper);

  RobotModel given_;
  RobotModel robot_;  ///< by what was found so far
  MapOptions options_;
  Threads threads_;
  MappingWatch& watch_;
  int made_anew_ = 0;
  Calibration newest_{};  ///< of the last mapping, where it is not the map
  Calibration found_{};   ///< by all of them
  std::vector<std::string> corrections_{};
};

/// What the log itself gives reason to say of its map: warnings before the map's own, and less
/// trust where much of it was left out.
/// \param changes  of its files, while they were read: LogFiles::changes()
void judge_by_log(const LogSummary& log, const std::vector<std::string>& changes,
                  MapResult& result);

/// A map and what it was made of.
struct LogMap {
  MapResult result{};
  RobotModel robot{};
  LogSummary log{};
  std::vector<std::string> corrections{};  ///< what its warnings say of a robot put right
};

/// Maps a log:
///
///   const LogMap made = map_log({.path = "run.mcap"});
///
/// `loopstone map LOG`, without what that writes; the floor's pictures are left out.
/// Cost: of Mapper, up to three times. Throws DataError when nothing can be made of the log, and as
/// open_log() does.
[[nodiscard]] LogMap map_log(const LogSource& source, const MapOptions& options = {},
                             Threads threads = {});

/// The same, with a part of it, and for who looks on. What was called off has a result that is not
/// complete.
/// \param reader     of the source, at its beginning
/// \param watch      who looks on while it is read
/// \param companion  null: nobody
[[nodiscard]] LogMap map_log(const LogSource& source, LogReader& reader, const LogCut& cut,
                             const MapOptions& options, Threads threads = {},
                             const ReadingWatch& watch = {}, MappingWatch* companion = nullptr);

}  // namespace loopstone
