#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/odometry/trajectory.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/robot_model.hpp"

// The formats of sensor logs: one table, which everything asks that opens, writes, names or
// describes logs. A new format is one more entry in src/formats/log_formats.cpp.

namespace loopstone {

struct LogFormat;
struct ReadableBytes;  // src/formats/byte_source.hpp: for the readers in this library

/// What a format has a place for. What it has none for is left out when a log is written, and
/// counted (LogWriter::notes()).
struct LogContents {
  bool scans = false;
  bool odometry_poses = false;  ///< odom_T_robot
  bool wheel_ticks = false;     ///< without a place for them they become poses, if it has poses
  bool imu_samples = false;
  bool rgbd_frames = false;
  int lidars = 1;                 ///< that it tells apart; a log of more can't be written
  bool beams_change = false;      ///< their number and directions may differ from scan to scan
  bool beam_times = false;        ///< LaserScan::time_increment_s
  bool intensities = false;       ///< LaserScan::intensities
  bool lidar_mount = false;       ///< robot_T_lidar
  bool single_precision = false;  ///< angles, limits and times of beams are 32-bit numbers
  Duration stamp_error{};         ///< by which a written stamp of this century may be off, at most
};

/// A kind of message, in people's words, and whether a format has a place for it.
struct MessageKind {
  std::string_view name{};  ///< "wheel readings"
  bool LogContents::*held = nullptr;
};

/// One for each alternative of SensorMessage, in its order.
[[nodiscard]] std::span<const MessageKind> message_kinds();
[[nodiscard]] bool holds(const LogContents& contents, const SensorMessage& message);

enum class LogPlace { kFile, kFolder };

/// How sure a format is that a log is its own. The surest opens it; of equals the first in the
/// table.
enum class Recognition { kNo, kPossible, kCertain };

/// A log that is there, before its format is known.
struct LogInput {
  std::string name{};  ///< for messages
  std::filesystem::path path{};
  std::optional<int> set{};  ///< of "DIR#20"
  bool is_folder = false;
  bool is_stream = false;  ///< a pipe: its bytes come once, from the beginning to the end
  std::string head{};  ///< the first bytes of a file, unpacked, as many as any format's mark has
  std::shared_ptr<const ReadableBytes> content{};  ///< of a file
};

/// A log that is to be written.
struct LogTarget {
  const LogFormat* format = nullptr;
  std::string path{};
  int set = kDefaultSet;  ///< for formats that have sets

  static constexpr int kDefaultSet = 20;
};

/// What a written log is made of: files, and folders that are all its own.
struct LogParts {
  std::vector<std::string> files{};
  std::vector<std::string> folders{};
};

/// A format of sensor logs: its words, its functions, what it can hold.
struct LogFormat {
  std::string_view name{};     ///< the word of --format, and of LogReader::format(): "carmen"
  std::string_view title{};    ///< as in "a CARMEN log"
  std::string_view noun{};     ///< as in "CARMEN text has no place for them"
  std::string_view file_is{};  ///< what one of its files is, as in "is an archive"
  LogPlace place = LogPlace::kFile;
  std::span<const std::string_view> endings{};   ///< of the names of its files: ".clf"
  std::span<const std::string_view> packings{};  ///< that may follow: ".gz"
  std::string_view expected{};     ///< in a folder, for the message when it is missing
  bool has_sets = false;           ///< a folder holds several logs, told apart by number
  bool reads_streams = false;      ///< can be read from a pipe
  bool has_picture_files = false;  ///< pictures are files beside the log, not messages in it
  LogContents holds{};

  /// By content; never throws for a log of another format.
  Recognition (*recognise)(const LogInput& log) = nullptr;
  /// Of a log that recognise() does not deny. Throws DataError with what is wrong.
  std::unique_ptr<LogReader> (*open)(const LogInput& log, const LogOptions& options) = nullptr;
  /// True poses that the log holds under a topic's name: truth_log.hpp. Of a log that recognise()
  /// does not deny. Absent: logs of this format hold none.
  Trajectory (*truth)(const LogInput& log, const std::string& topic,
                      const LogOptions& options) = nullptr;
  /// The files that are read, told by names alone, so that pipes and damaged files stay
  /// untouched; none when it can't be this format by its name. Absent: a log is one file.
  std::vector<std::string> (*files)(const LogInput& log) = nullptr;
  /// Absent: it is only read. The writer is given what `holds` has a place for.
  std::unique_ptr<LogWriter> (*create)(const LogTarget& target, const RobotModel& robot) = nullptr;
  /// What create() may write. Absent: the one file that is named.
  LogParts (*parts)(const LogTarget& target) = nullptr;

  [[nodiscard]] bool can_be_written() const { return create != nullptr; }
};

/// All of them, in the order in which they are asked and told.
[[nodiscard]] std::span<const LogFormat> log_formats();
/// Nothing when there is no format of this name.
[[nodiscard]] const LogFormat* find_log_format(std::string_view name);
/// Throws UsageError, which names those that there are.
[[nodiscard]] const LogFormat& log_format(std::string_view name);

/// Whether a file's name ends as those of the format do, packed or not.
[[nodiscard]] bool has_log_ending(const LogFormat& format, std::string_view file_name);
/// Whether it ends as those of any format.
[[nodiscard]] bool has_log_ending(std::string_view file_name);

/// Looks at a log as open_log() takes it; of a pipe what was looked at is kept for the reader.
/// \param stop  as LogOptions::stop
/// Throws DataError when there is nothing or it can't be a log, UsageError for a file's "#set".
[[nodiscard]] LogInput look_at_log(const std::string& path, std::function<bool()> stop = {});

/// Throws DataError when no format takes it, saying what it is, if that is known, and what was
/// expected.
[[nodiscard]] const LogFormat& recognise_log(const LogInput& log);

/// Opens a log as of this format. Throws DataError, or UsageError, when it can't be that.
[[nodiscard]] std::unique_ptr<LogReader> open_log(const LogInput& log, const LogFormat& format,
                                                  const LogOptions& options = {});

/// Where a log goes: the format follows from its name (an ending, or a folder) unless it is
/// given. "DIR#21" names the set, for formats that have sets.
/// Throws UsageError when the format is unknown, can't be written or does not follow.
[[nodiscard]] LogTarget log_target(const std::string& path,
                                   const std::optional<std::string>& format = {});

/// What create_log() may write there.
[[nodiscard]] LogParts log_parts(const LogTarget& target);

/// A writer that leaves out what the format has no place for, and tells so in its notes().
[[nodiscard]] std::unique_ptr<LogWriter> create_log(const LogTarget& target,
                                                    const RobotModel& robot);

}  // namespace loopstone
