#include <cstddef>
#include <cstdint>

#include "formats/npy.hpp"
#include "loopstone/base/error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    (void)loopstone::read_npy(
        loopstone::memory_byte_source({reinterpret_cast<const char*>(data), size}), "fuzz");
  } catch (const loopstone::DataError&) {
    // Damage is expected to be refused, and nothing worse.
  }
  return 0;
}
