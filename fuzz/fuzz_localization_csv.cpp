#include <cstddef>
#include <cstdint>
#include <string_view>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/localization_csv.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto estimates =
        loopstone::parse_localization_csv({reinterpret_cast<const char*>(data), size});
    // What was read can be written and read again.
    (void)loopstone::parse_localization_csv(loopstone::format_localization_csv(estimates));
  } catch (const loopstone::DataError&) {
    // Damage is expected to be refused, and nothing worse.
  }
  return 0;
}
