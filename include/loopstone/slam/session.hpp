#pragma once

#include <cstdint>
#include <string>

#include "loopstone/sensor/log_digest.hpp"
#include "loopstone/slam/mapper_state.hpp"

namespace loopstone {

/// What a run has in common with the one whose session it goes on with; else it would not lead to
/// the same result.
struct SessionTerms {
  std::string version{};  ///< of Loopstone
  std::string options_toml{};
  std::string robot_toml{};
  bool mounts_from_log = true;
  double start_s = 0.0;  ///< the part of the log that is used
  double duration_s = 0.0;
  std::int64_t max_scans = 0;

  template <typename Archive>
  void archive(Archive& a) {
    a(version, options_toml, robot_toml, mounts_from_log, start_s, duration_s, max_scans);
  }
};

/// What differs, in words with both values; empty when nothing does.
[[nodiscard]] std::string difference(const SessionTerms& session, const SessionTerms& now);

/// A run that can be gone on with, as plain data. write_session() (formats/session_file.hpp) keeps
/// it in a file.
struct Session {
  /// Raised whenever a field of it, or of anything in it, changes.
  static constexpr std::uint32_t kVersion = 9;

  SessionTerms terms{};
  LogDigest log{};      ///< of all messages that the mapper has dealt with
  double wall_s = 0.0;  ///< that led to it
  double cpu_s = 0.0;
  MapperState mapper{};

  template <typename Archive>
  void archive(Archive& a) {
    a(terms, log, wall_s, cpu_s, mapper);
  }
};

}  // namespace loopstone
