#pragma once

#include <string_view>

namespace loopstone {

/// The version of the library and the program. CMake, the package config and `summary.json` read it
/// from here.
inline constexpr std::string_view kVersion = "0.2.0";

}  // namespace loopstone
