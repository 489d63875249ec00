#include <cstddef>
#include <cstdint>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/point_cloud_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const loopstone::PointCloud cloud =
        loopstone::decode_ply({reinterpret_cast<const char*>(data), size});
    // What was read can be written and read again.
    if (loopstone::decode_ply(loopstone::encode_ply(cloud)).points.size() != cloud.points.size())
      __builtin_trap();
  } catch (const loopstone::DataError&) {
    // Damage is expected to be refused, and nothing worse.
  }
  return 0;
}
