#include <cstddef>
#include <cstdint>
#include <string_view>

#include "formats/carmen_reader.hpp"

// Plain, gzip and bzip2 alike: the reader looks at the first bytes.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto log = loopstone::read_carmen_log({reinterpret_cast<const char*>(data), size}, {});
    while (log->next()) {
    }
    (void)log->notes();
  } catch (const loopstone::DataError&) {
    // Damage is expected to be refused, and nothing worse.
  }
  return 0;
}
