#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "loopstone/base/memory_budget.hpp"
#include "loopstone/slam/session.hpp"

namespace loopstone {

// The file of a run that can be gone on with, as docs/session.md describes it: a head with the
// version, the session's fields, and a checksum each.

/// Writes a session and returns the bytes of the file. One of that name stays as it was until the
/// new one is whole on disk. Throws DataError when it can't be written.
std::int64_t write_session(const std::string& path, const Session& session);

/// The bytes of such a file.
[[nodiscard]] std::string format_session(const Session& session);

/// Throws DataError that names the offset: when the bytes are no session, of another version, cut
/// off or changed anywhere. Whether its parts fit together is for the mapper to say.
[[nodiscard]] Session parse_session(std::string_view bytes, const std::string& path);

/// Throws DataError, also when the file can't be read.
[[nodiscard]] Session read_session(const std::string& path, const MemoryBudget& budget = {});

}  // namespace loopstone
