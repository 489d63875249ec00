#pragma once

#include <string>
#include <string_view>

namespace loopstone {

/// Writes a text file whole or not at all. Throws DataError that names the file when it can't be
/// written.
void write_text_file(const std::string& path, std::string_view text);

}  // namespace loopstone
