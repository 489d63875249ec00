#pragma once

#include <cstdint>
#include <string>

namespace loopstone {

/// Makes sure that a file of this name can be made, and that so many bytes are free for it: better
/// found out before the work than after. What stands under the name is left alone. Throws DataError
/// naming the file.
void require_room(const std::string& path, std::int64_t least_bytes);

/// Throws UsageError where there is something under the name of a file that is to be made.
void require_free_name(const std::string& path);

/// Removes the hidden files and folders that a run leaves when it is killed before they are
/// complete (".map.png.1234-0.partial"): those of processes that are gone, and of this one, so that
/// it is for before the first file is begun, or after the last.
/// \param name  only of this file; empty: all in the folder
void remove_partial_files(const std::string& folder, const std::string& name = {});

/// Whether a folder holds nothing but what remove_partial_files() would remove. Throws DataError
/// when it can't be looked into.
[[nodiscard]] bool holds_nothing(const std::string& folder);

}  // namespace loopstone
