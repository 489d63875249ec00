#include <cstddef>
#include <cstdint>
#include <string_view>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/tum.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto read = loopstone::parse_tum({reinterpret_cast<const char*>(data), size});
    const auto again = loopstone::parse_tum(loopstone::format_tum(read));
    if (again.size() != read.size() || again.front().stamp != read.front().stamp) __builtin_trap();
  } catch (const loopstone::DataError&) {
    // Damage is expected to be refused, and nothing worse.
  }
  return 0;
}
