#include <cstddef>
#include <cstdint>
#include <string_view>

#include "formats/npz.hpp"
#include "formats/ucsd_sensors.hpp"
#include "loopstone/base/error.hpp"

namespace {

/// Reads the archive as this sensor, to the last record.
template <typename Open>
void read_as(const loopstone::NpzFile& file, Open&& open) {
  try {
    const loopstone::UcsdChannel channel = open(file, "fuzz");
    for (std::size_t i = 0; i < channel.kept.stamps.size(); ++i) {
      (void)channel.make(channel.kept.stamps[i], channel.kept.indices[i]);
    }
  } catch (const loopstone::DataError&) {
    // Damage is expected to be refused, and nothing worse.
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const loopstone::NpzFile file({reinterpret_cast<const char*>(data), size}, "fuzz");
    read_as(file, loopstone::open_ucsd_encoders);
    read_as(file, loopstone::open_ucsd_imu);
    read_as(file, loopstone::open_ucsd_hokuyo);
    read_as(file, loopstone::open_ucsd_odometry);
  } catch (const loopstone::DataError&) {
  }
  return 0;
}
