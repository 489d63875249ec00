#include "formats/npz.hpp"
#include "formats/ucsd_sensors.hpp"
#include "refusal.hpp"

namespace {

using namespace loopstone;

/// Reads the archive as this sensor, to the last record.
template <typename Open>
void read_as(const NpzFile& file, std::string_view bytes, Open&& open) {
  fuzz::expect_work_or_refusal(bytes, [&] {
    const UcsdChannel channel = open(file, "fuzz");
    for (std::size_t i = 0; i < channel.kept.stamps.size(); ++i) {
      (void)channel.make(channel.kept.stamps[i], channel.kept.indices[i]);
    }
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes = fuzz::text_of(data, size);
  return fuzz::expect_work_or_refusal(bytes, [&] {
    const NpzFile file(bytes, "fuzz");
    read_as(file, bytes, open_ucsd_encoders);
    read_as(file, bytes, open_ucsd_imu);
    read_as(file, bytes, open_ucsd_hokuyo);
    read_as(file, bytes, open_ucsd_odometry);
  });
}
