#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include "source_folder.hpp"

namespace loopstone::test {

/// Where a file of the recorded data lies: under LOOPSTONE_DATA, else ../shared/data beside the
/// project. Empty when it is not there; then the test says so and is skipped.
[[nodiscard]] inline std::string recorded_data(const std::string& name) {
  const char* set = std::getenv("LOOPSTONE_DATA");
  const std::filesystem::path root =
      set != nullptr ? std::filesystem::path(set)
                     : std::filesystem::path(LOOPSTONE_SOURCE_DIR).parent_path() / "shared/data";
  const std::filesystem::path path = root / name;
  std::error_code ignored;
  return std::filesystem::exists(path, ignored) ? path.string() : std::string{};
}

}  // namespace loopstone::test
