#pragma once

#include <cstdint>
#include <string>

#include "loopstone/base/error.hpp"
#include "loopstone/base/number_text.hpp"
#include "loopstone/base/stamp.hpp"

namespace loopstone {

/// For containers that count from 1970 and not backwards. Throws DataError for earlier stamps.
[[nodiscard]] inline std::uint64_t written_nanoseconds(Stamp stamp, const std::string& path) {
  if (stamp.nanoseconds >= 0) return static_cast<std::uint64_t>(stamp.nanoseconds);
  throw DataError({path}, "a message of " + number_text(stamp.seconds()) +
                              " s can't be written: a recording has no place for times before 0");
}

}  // namespace loopstone
