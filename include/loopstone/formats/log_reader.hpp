#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/memory_budget.hpp"
#include "loopstone/base/words.hpp"
#include "loopstone/formats/left_out.hpp"
#include "loopstone/formats/picture_store.hpp"
#include "loopstone/formats/topic_options.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/robot_model.hpp"

namespace loopstone {

/// Where the stamps of a log's messages come from.
enum class StampUse {
  kAuto,    ///< what the format's reader finds to be usable; a warning tells what is not `header`
  kHeader,  ///< the message's own: when the sensor measured
  kRecord,  ///< when the recorder got the message
  kOrder,   ///< made up from the order of the records and their rate
};

constexpr auto words_of(StampUse /*any*/) {
  using enum StampUse;
  return std::array{Word{kAuto, "auto"}, Word{kHeader, "header"}, Word{kRecord, "record"},
                    Word{kOrder, "order"}};
}

/// A log is read while it is measured: messages come out at once, in the order in which they come,
/// whatever their stamps.
struct LiveReading {
  /// What must be known before the first message is taken from what comes so long after the first
  /// byte, and until a scan has come.
  double look_s = 2.0;
};

/// How a log is to be read.
struct LogOptions {
  /// Damage (broken, repeated, out-of-order records) is an error instead of being counted and
  /// skipped.
  bool strict = false;
  /// Formats that know only one kind of stamps use that.
  StampUse stamps = StampUse::kAuto;
  /// Told about every record that is skipped. May be empty.
  std::function<void(const LogProblem&)> on_problem{};
  /// What an archive may take while it is read.
  MemoryBudget memory{};
  /// Asked now and then while bytes are read, also by another thread: true ends the log at once.
  /// May be empty.
  std::function<bool()> stop{};
  /// Else messages wait until their order is sure.
  std::optional<LiveReading> live{};
  /// Scans bring the intensities of their beams, where the log has them.
  bool intensities = false;
  /// Of recordings with topics.
  TopicOptions topics{};
};

/// LogOptions::stop said so before there was anything to give.
class ReadingStopped : public std::runtime_error {
 public:
  ReadingStopped() : std::runtime_error("interrupted while the log was read") {}
};

/// How far a reader has come, in bytes of the file as stored.
struct ReadProgress {
  std::int64_t bytes_done = 0;
  std::int64_t bytes_total = 0;
};

/// A log as a stream of messages in time order; bounded memory whatever the length of the log.
class LogReader {
 public:
  virtual ~LogReader() = default;

  /// The next message, or nothing at the end or when LogOptions::stop said so. Throws DataError
  /// when the log can't be read any further.
  [[nodiscard]] virtual std::optional<SensorMessage> next() = 0;
  [[nodiscard]] virtual ReadProgress progress() const = 0;
  /// The name of its entry in log_formats(): "carmen", "ucsd".
  [[nodiscard]] virtual std::string format() const = 0;
  /// `base` with everything that the log itself states about the robot (mounts, wheels) written
  /// over it.
  [[nodiscard]] virtual RobotModel robot(RobotModel base) const = 0;
  /// By which this log's WheelTicks are to be read: `base`, or where they are made of something
  /// else (angles of joints) what was taken for that, whatever a robot file says.
  [[nodiscard]] virtual WheelModel wheels(WheelModel base) const { return base; }
  /// What was skipped so far because it was broken, repeated or too late.
  [[nodiscard]] virtual const SkippedRecords& skipped() const = 0;
  [[nodiscard]] std::int64_t records_skipped() const { return skipped().records; }
  /// What a user should know about this log beside the skipped records, in plain words; complete
  /// after the last message. Nothing here makes the log unusable.
  [[nodiscard]] virtual std::vector<std::string> notes() const { return {}; }
  /// The same for what makes a result worse than the log could give; complete after the last
  /// message.
  [[nodiscard]] virtual std::vector<std::string> warnings() const { return {}; }
  /// What was chosen where the log left a choice, in plain words: "laser: /scan (...)".
  [[nodiscard]] virtual std::vector<std::string> choices() const { return {}; }
  /// What RgbdFrame::depth_message and colour_message are numbers of; complete after the last
  /// message, and not to be asked before. Nothing when pictures are files.
  [[nodiscard]] virtual std::shared_ptr<const PictureStore> pictures() const { return nullptr; }
  /// Why what the log says of its camera is not enough to use it without a robot file, in plain
  /// words; empty when it is enough, and for logs that leave the camera to the robot's model.
  [[nodiscard]] virtual std::string camera_fault() const { return {}; }
  /// The topics of a recording; counts and rates are complete after the last message.
  [[nodiscard]] virtual std::vector<TopicSummary> topics() const { return {}; }
};

/// Opens a file, a pipe or a folder; finds out the format by its content. "DIR#20" names set 20 of
/// a UCSD folder, "-" is the standard input. A pipe is read once, as it comes. Throws DataError
/// when there is nothing readable, saying what was found and what was expected; ReadingStopped.
[[nodiscard]] std::unique_ptr<LogReader> open_log(const std::string& path,
                                                  const LogOptions& options = {});

/// The same log, read by a thread of its own a few hundred messages ahead of next(). Messages,
/// problems, progress and counts come as they would from open_log(), and problems are told by
/// whoever calls next().
[[nodiscard]] std::unique_ptr<LogReader> open_log_ahead(const std::string& path,
                                                        const LogOptions& options = {});

/// Writes a log. Nothing appears under the final name before finish().
class LogWriter {
 public:
  virtual ~LogWriter() = default;
  /// Messages come in time order.
  virtual void write(const SensorMessage& message) = 0;
  /// Before the first frame whose pictures are messages of a recording: what they are numbers of.
  // NOLINTNEXTLINE(performance-unnecessary-value-param): writers keep it
  virtual void use_pictures(std::shared_ptr<const PictureStore> /*pictures*/) {}
  /// Completes the files and moves them to their final names. Without it the destructor removes
  /// what was written.
  virtual void finish() = 0;
  /// What the format could not carry or carries in its own way, in plain words; complete after
  /// finish().
  [[nodiscard]] virtual std::vector<std::string> notes() const { return {}; }
};

/// A writer that leaves out what the format has no place for, and tells so in its notes().
/// \param path    of a file or a folder, as the format is either
/// \param format  the name of one that can be written (log_format.hpp): "carmen", "ucsd"
/// \param set     of a format whose folders hold several
/// Throws UsageError for a format that there is not, DataError when nothing can be written there.
[[nodiscard]] std::unique_ptr<LogWriter> create_log(const std::string& path,
                                                    const std::string& format,
                                                    const RobotModel& robot, int set = 20);

}  // namespace loopstone
