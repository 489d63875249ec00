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

/// Where the state of a finished map lies in the folder of its results, from which another drive
/// goes on and edits begin.
[[nodiscard]] std::string kept_state_path(const std::string& folder);
/// It. Throws DataError when there is none, it is damaged, or of another version of loopstone.
/// \param to_do  what it is wanted for, in that error: "go on from"
[[nodiscard]] Session read_kept_state(const std::string& folder, const std::string& to_do,
                                      const MemoryBudget& budget = {});
/// Whether the map there came of edits, of which its state knows nothing.
[[nodiscard]] bool is_edited_map(const std::string& folder);
/// One of an older map is not of new results.
void remove_kept_state(const std::string& folder);

}  // namespace loopstone
