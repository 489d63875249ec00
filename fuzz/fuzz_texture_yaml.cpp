#include <cstddef>
#include <cstdint>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/texture_files.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    (void)loopstone::parse_texture_yaml({reinterpret_cast<const char*>(data), size});
  } catch (const loopstone::DataError&) {
    // Damage is expected to be refused, and nothing worse.
  }
  return 0;
}
