#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "formats/byte_source.hpp"
#include "formats/carmen_line.hpp"
#include "loopstone/base/stamp.hpp"
#include "loopstone/formats/log_reader.hpp"
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
  /// Whose stamps are used; never kAuto.
  StampUse stamps = StampUse::kHeader;
  /// What is wrong with the scans' own stamps, where that is why others are used.
  std::string stamp_fault{};
  /// For stamps that are made up.
  double scan_rate_hz = 0.0;
  std::string rate_origin{};
  bool scans_carry_odometry = false;
  std::optional<Stamp>
      early_stamp{};  ///< of a scan near the beginning: the median of the first few
  bool pose_is_corrected =
      false;  ///< the first pose of the scans wanders against the second: not a mount
  bool made_by_a_mapper = false;  ///< NEFF and the like: the log is another program's result
  /// robot_T_lidar by the poses in the log, constant over the sample.
  std::array<std::optional<Pose2>, kCarmenLidars> mounts{};
  std::array<bool, kCarmenLidars> seen{};  ///< lasers of the sample
  /// FLASER and RLASER: this range and everything above it means "nothing within reach".
  double no_return_m = 0.0;
  /// Told by a value that many beams share at the very top of all ranges, not by the scanner's data
  /// sheet.
  bool no_return_by_histogram = false;
  std::map<std::string, std::string> params{};

  [[nodiscard]] std::optional<double> param(const std::string& name) const;
};

/// \param wanted  stamps that the user asked for; by kAuto the survey decides
[[nodiscard]] CarmenSurvey survey_carmen(const ReadableBytes& log, StampUse wanted);

}  // namespace loopstone
