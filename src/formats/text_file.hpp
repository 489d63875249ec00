#pragma once

#include <string>

namespace loopstone {

/// The whole of a small file (options, relations, trajectories). Throws DataError naming the path and the reason.
[[nodiscard]] std::string read_text_file(const std::string& path);

}  // namespace loopstone
