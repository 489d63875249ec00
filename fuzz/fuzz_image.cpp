#include <cstddef>
#include <cstdint>
#include <string_view>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/ros_map.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto image = loopstone::decode_image({reinterpret_cast<const char*>(data), size});
    (void)loopstone::interpret_map(image, {});
  } catch (const loopstone::DataError&) {
    // Damage is expected to be refused, and nothing worse.
  }
  return 0;
}
