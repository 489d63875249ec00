#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/base/progress.hpp"
#include "loopstone/base/stamp.hpp"
#include "loopstone/base/words.hpp"
#include "loopstone/formats/left_out.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// When the records of one sensor came.
struct TimingSummary {
  std::int64_t records = 0;
  Stamp first{};
  Stamp last{};
  double rate_hz = 0.0;  ///< mean over the log; 0 with fewer than two records
  double largest_gap_s = 0.0;
  Stamp largest_gap_at{};  ///< where it begins
  std::int64_t gaps = 0;   ///< intervals of more than five usual ones and half a second
};

/// How many beams said what.
struct RangeClasses {
  std::int64_t returns = 0;    ///< finite and within the scanner's limits
  std::int64_t no_return = 0;  ///< +inf
  std::int64_t bad = 0;        ///< NaN
  std::int64_t too_near = 0;   ///< finite, below range_min_m
  std::int64_t too_far = 0;    ///< finite, above range_max_m

  [[nodiscard]] std::int64_t total() const {
    return returns + no_return + bad + too_near + too_far;
  }
};

/// One beam layout that occurs in the log.
struct BeamLayout {
  std::size_t beams = 0;
  double angle_min_rad = 0.0;
  double angle_increment_rad = 0.0;
  std::int64_t scans = 0;

  [[nodiscard]] double field_of_view_rad() const;
};

struct LidarSummary {
  int lidar = 0;
  TimingSummary timing{};
  std::vector<BeamLayout> layouts{};  ///< most frequent first
  double range_min_m = 0.0;
  double range_max_m = 0.0;
  double time_increment_s = 0.0;
  std::optional<Pose2> robot_T_lidar{};  ///< when the log states it
  RangeClasses ranges{};
  /// Of the returns, to 1 cm: smallest, 5 %, 25 %, 50 %, 75 %, 95 %, largest [m].
  std::array<double, 7> range_percentiles_m{};
  /// Returns by distance: [0, 0.5), [0.5, 1), [1, 2), [2, 4), [4, 8), [8, 16), [16, 32), from 32 m
  /// on.
  std::array<std::int64_t, 8> range_histogram{};
  std::int64_t repeated_scans = 0;  ///< bit for bit the same as the scan before
};

/// Where and how the robot went, as its own dead reckoning tells.
struct OdometrySummary {
  TimingSummary timing{};
  double path_length_m = 0.0;
  double turned_rad = 0.0;  ///< sum of all turns, either way
  double largest_step_m = 0.0;
  std::int64_t jumps = 0;  ///< steps of more than 0.5 m at more than 10 m/s
};

struct WheelSummary {
  TimingSummary timing{};
  std::array<std::int64_t, 4> travelled_counts{};  ///< sum of the absolute counts [FR, FL, RR, RL]
};

struct ImuSummary {
  TimingSummary timing{};
  double median_acceleration_m_s2 =
      0.0;                       ///< of the length of the vector; 9.8 when gravity is in it
  double gravity_along_z = 0.0;  ///< mean of z / length: 1 when z points up
  double median_yaw_rate_rad_s =
      0.0;  ///< about the bias, for a robot that drives straight or stands most of the time
};

/// Columns and rows of a picture; 0 when there is none or it can't be read.
struct PictureSize {
  int width_px = 0;
  int height_px = 0;
  std::string problem{};  ///< why it can't be read
};

/// An RGB-D camera: two streams of pictures that may run apart.
struct CameraSummary {
  TimingSummary frames{};  ///< pairs, and pictures that are alone
  TimingSummary depth{};
  TimingSummary colour{};
  std::int64_t pairs = 0;
  /// Stamp of colour less stamp of depth within the pairs; the largest by its size.
  double largest_offset_s = 0.0;
  double median_offset_s = 0.0;
  PictureSize depth_size{};  ///< of the first picture
  PictureSize colour_size{};
};

enum class Severity { kNote, kWarning, kError };

constexpr auto words_of(Severity /*any*/) {
  using enum Severity;
  return std::array{Word{kNote, "note"}, Word{kWarning, "warning"}, Word{kError, "error"}};
}

/// Something that a user should know, in plain words.
struct Finding {
  Severity severity = Severity::kNote;
  std::string text;
};

struct LogSummary {
  std::string format;
  std::int64_t bytes = 0;
  LeftOut left_out{};
  std::optional<Stamp> first{};
  std::optional<Stamp> last{};
  std::vector<LidarSummary> lidars{};
  std::optional<OdometrySummary> odometry{};
  std::optional<WheelSummary> wheels{};
  std::optional<ImuSummary> imu{};
  std::optional<CameraSummary> camera{};
  std::vector<TopicSummary> topics{};  ///< of a recording with topics
  std::vector<std::string> choices{};  ///< what was chosen where the log leaves a choice
  bool complete = true;                ///< false when it was interrupted
  /// Worst first. An error means that no map can be made.
  std::vector<Finding> findings{};

  [[nodiscard]] double duration_s() const { return first ? (*last - *first).seconds() : 0.0; }
  [[nodiscard]] std::int64_t scans() const;
  [[nodiscard]] Severity worst() const;
  /// In one line: whether a map can be made of it.
  [[nodiscard]] std::string verdict() const;
  /// "laser", or of several "laser 2".
  [[nodiscard]] std::string name_of(const LidarSummary& lidar) const;
};

/// How bad it is that so much was left out: nothing when all was used. From 5 % on it is a warning,
/// and an error when hardly a scan is left (or a record, in a log without scans).
[[nodiscard]] std::optional<Finding> judge(const LeftOut& left_out);
/// The same; throws DataError, which names the log, in place of an error.
[[nodiscard]] std::optional<Finding> judge(const LeftOut& left_out, const std::string& path);

/// Counts what goes by and what the reader skipped meanwhile.
class LeftOutCounter {
 public:
  /// The reader must outlive this.
  explicit LeftOutCounter(const LogReader& log) : log_(&log) {}
  /// A message that the reader gave last.
  void add(const SensorMessage& message);
  [[nodiscard]] LeftOut left_out() const;

 private:
  [[nodiscard]] double since_start_s() const;

  const LogReader* log_;
  LeftOut counts_{};  ///< without what was skipped
  std::optional<Stamp> first_{};
  Stamp last_{};
};

/// Looks at the messages of a log as they go by, on their way to something else.
class LogAnalyser {
 public:
  /// The reader must outlive this.
  explicit LogAnalyser(const LogReader& log);
  ~LogAnalyser();
  LogAnalyser(LogAnalyser&&) noexcept;
  LogAnalyser& operator=(LogAnalyser&&) noexcept;

  /// A message that the reader gave last.
  void add(const SensorMessage& message);
  /// What was in the log as far as it was read; nothing can be added afterwards.
  [[nodiscard]] LogSummary finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// One JSON object with units in the names of its keys, as `loopstone info --json` prints it.
/// \param log  its path, as the user named it
[[nodiscard]] std::string log_summary_json(const LogSummary& summary, const std::string& log);

/// Reads a log to its end and tells what is in it. One pass; memory grows with 4 bytes a record.
/// Throws what the reader throws.
[[nodiscard]] LogSummary analyse_log(LogReader& log, const ProgressCallback& progress = {});

}  // namespace loopstone
