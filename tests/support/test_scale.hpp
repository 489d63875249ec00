#pragma once

#include <cstdlib>
#include <string_view>

namespace loopstone::test {

/// LOOPSTONE_TEST_SCALE=small: short drives, few seeds; for sanitizers.
[[nodiscard]] inline bool small_scale() {
  const char* scale = std::getenv("LOOPSTONE_TEST_SCALE");
  return scale != nullptr && std::string_view(scale) == "small";
}

}  // namespace loopstone::test
