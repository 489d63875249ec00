#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "loopstone/formats/log_format.hpp"

// What people are told of log formats, made of the table of formats.

namespace loopstone {

/// "a, b and c".
[[nodiscard]] std::string listed(const std::vector<std::string>& words, std::string_view last);

/// The names of the formats that can be written and hold what is asked for: words of --format.
/// \param needed  of LogContents, such as &LogContents::rgbd_frames
[[nodiscard]] std::vector<std::string> writable_log_formats(bool LogContents::*needed = nullptr);

/// "a file (CARMEN text, also .gz and .bz2) or a folder (the UCSD layout; DIR#20 names set 20)".
[[nodiscard]] std::string what_a_log_is();

/// Which name of an output means which format: ".clf and .log, also with .gz or .bz2, are CARMEN
/// text", "a folder is ...".
[[nodiscard]] std::vector<std::string> log_name_meanings();

/// The whole table, for people.
[[nodiscard]] std::string log_formats_text();
/// The same as one JSON object: {"formats": [{"name": "carmen", ..., "holds": {...}}, ...]}.
[[nodiscard]] std::string log_formats_json();

}  // namespace loopstone
