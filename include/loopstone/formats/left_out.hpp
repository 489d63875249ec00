#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/base/error.hpp"

namespace loopstone {

/// A record that a log reader skipped.
struct LogProblem : Problem {
  bool is_scan = false;  ///< of a laser, as far as the record still tells
};

/// Records that were skipped for one reason. Reasons that differ in their figures alone count as
/// one.
struct SkipReason {
  std::string reason{};  ///< of the first of them
  Location first{};
  std::int64_t records = 0;
};

/// What a reader skipped so far because it was broken, repeated or out of order.
struct SkippedRecords {
  std::int64_t records = 0;
  std::int64_t scans = 0;             ///< laser scans among them
  std::vector<SkipReason> reasons{};  ///< in the order in which they first occurred
};

/// How much of a log was not used, of how much, why and since when.
struct LeftOut {
  SkippedRecords skipped{};
  std::int64_t records_read = 0;    ///< used
  std::int64_t scans_read = 0;      ///< laser scans among them
  std::optional<double> since_s{};  ///< the first one, after the log's beginning [s]

  [[nodiscard]] std::int64_t records() const { return records_read + skipped.records; }
  [[nodiscard]] std::int64_t scans() const { return scans_read + skipped.scans; }
  /// Of the scans and of all records, 0 to 1.
  [[nodiscard]] double scan_share() const;
  [[nodiscard]] double record_share() const;
  /// The larger of both.
  [[nodiscard]] double share() const;
  /// "13630 of 13631 scans (99.9 %) were left out since 0.0 s: a scan with ... (13630 times, first
  /// log.clf:15)".
  [[nodiscard]] std::string sentence() const;
};

/// One JSON object: counts, shares, reasons.
[[nodiscard]] std::string left_out_json(const LeftOut& left_out);

}  // namespace loopstone
