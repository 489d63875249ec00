#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "formats/byte_source.hpp"
#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"

namespace loopstone {

/// What a CARMEN log does not say line by line and a reader must know before the first scan: found
/// by looking at a few hundred scans, spread over the file.
struct CarmenSurvey {
  bool any_record = false;  ///< at least one line that this reader understands
  bool any_scan = false;
  /// When no line was understood: the first that begins as one of a CARMEN log, and what is wrong
  /// with it.
  struct Refusal {
    std::int64_t line = 0;
    std::string reason{};
  };
  std::optional<Refusal> first_refusal{};
  /// All scans that were looked at have the same stamp, but were written down at different times:
  /// these are their stamps.
  bool stamps_are_the_loggers = false;
  bool scans_carry_odometry = false;
  std::optional<Stamp>
      early_stamp{};  ///< of a scan near the beginning: the median of the first few
  bool pose_is_corrected =
      false;  ///< the first pose of the scans wanders against the second: not a mount
  bool made_by_a_mapper = false;  ///< NEFF and the like: the log is another program's result
  std::optional<Pose2>
      front_mount{};  ///< robot_T_lidar by the poses in the log, constant over the sample
  std::optional<Pose2> rear_mount{};
  /// FLASER and RLASER: this range and everything above it means "nothing within reach".
  double no_return_m = 0.0;
  /// Told by a value that many beams share at the very top of all ranges, not by the scanner's data
  /// sheet.
  bool no_return_by_histogram = false;
  std::map<std::string, std::string> params{};

  [[nodiscard]] std::optional<double> param(const std::string& name) const;
};

[[nodiscard]] CarmenSurvey survey_carmen(const ReadableBytes& log);

}  // namespace loopstone
