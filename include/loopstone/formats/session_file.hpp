#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/memory_budget.hpp"
#include "loopstone/base/state_chunk.hpp"

namespace loopstone {

// The state of a run that can be gone on with, as docs/session.md describes it: a head, chunks with
// a checksum each, and an end that counts them.

/// Writes a session. A file of that name stays as it was until the new one is whole on disk. Throws
/// DataError when it can't be written.
void write_session(const std::string& path, std::span<const StateChunk> chunks);

/// The bytes of such a file.
[[nodiscard]] std::string format_session(std::span<const StateChunk> chunks);

/// Throws DataError that names the offset: when the bytes are no session, of another version of the
/// format, cut off or changed anywhere.
[[nodiscard]] std::vector<StateChunk> parse_session(std::string_view bytes,
                                                    const std::string& path);

/// Throws DataError, also when the file can't be read.
[[nodiscard]] std::vector<StateChunk> read_session(const std::string& path,
                                                   const MemoryBudget& budget = {});

}  // namespace loopstone
