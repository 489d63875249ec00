#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/progress.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/log_summary.hpp"

namespace loopstone {

/// The part of a log that is used.
struct LogCut {
  double start_s = 0.0;        ///< scans before are skipped
  double duration_s = 0.0;     ///< 0: to the end
  std::int64_t max_scans = 0;  ///< 0: all
};

/// Who looks on while a log is read, and may call it off.
struct ReadingWatch {
  std::function<bool()> stop{};  ///< asked at every message; may be empty
  ProgressCallback progress{};   ///< told at every scan; may be empty
};

/// The messages of a log within a cut, until they are called off, and what is to be said of them.
class CutLog {
 public:
  /// \param mounts_from_log  what scans say of their laser's place on the robot counts
  /// \param step             what progress calls the work: "mapping"
  CutLog(LogReader& reader, const LogCut& cut, bool mounts_from_log, std::string_view step,
         ReadingWatch watch = {});

  [[nodiscard]] std::optional<SensorMessage> next();
  /// Called off by who looks on.
  [[nodiscard]] bool interrupted() const { return interrupted_; }
  [[nodiscard]] std::int64_t scans() const { return scans_; }
  /// What `loopstone info` says of the log, as far as it was read; when all is read.
  /// \param path  of the log, for errors
  /// Throws DataError with its reasons when nothing can be made of it, unless it was called off.
  [[nodiscard]] LogSummary judge(const std::string& path);

 private:
  LogReader& reader_;
  LogAnalyser analyser_;
  LogCut cut_;
  bool mounts_from_log_;
  std::string step_;
  ReadingWatch watch_;
  std::optional<Stamp> first_{};
  std::int64_t scans_ = 0;
  bool interrupted_ = false;
};

/// The texts of the findings that are warnings.
[[nodiscard]] std::vector<std::string> warnings_of(const LogSummary& summary);

}  // namespace loopstone
