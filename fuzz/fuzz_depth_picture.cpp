#include <cstddef>
#include <cstdint>
#include <string_view>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/rgbd_files.hpp"
#include "loopstone/sensor/camera_geometry.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const loopstone::DepthEncoding encoding;
  static const auto table = loopstone::inverse_depth_table(encoding);
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  try {
    (void)loopstone::decode_depth(bytes, encoding, table);
  } catch (const loopstone::DataError&) {
    // Damage is expected to be refused, and nothing worse.
  }
  try {
    (void)loopstone::decode_colour(bytes);
  } catch (const loopstone::DataError&) {
    // As above.
  }
  return 0;
}
