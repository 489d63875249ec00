#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "support/recording_builder.hpp"

namespace loopstone::test {

/// A recording that was spoiled, and which of its messages are none the worse for it.
struct DamagedRecording {
  std::string bytes{};
  std::vector<bool> is_whole{};  ///< by message
  std::string what{};
};

/// Flips bits, cuts, inserts or overwrites; the same for the same seed.
[[nodiscard]] DamagedRecording damaged(const BuiltRecording& recording, std::size_t messages,
                                       std::uint64_t seed);

/// Reads all that there is; of what it gives, which of `messages` are there (by time and bytes).
/// Throws when the reader does.
[[nodiscard]] std::vector<bool> found_in(Recording& recording,
                                         const std::vector<BuiltMessage>& messages);

}  // namespace loopstone::test
