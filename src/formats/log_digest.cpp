#include "loopstone/formats/log_digest.hpp"

#include <zlib.h>

#include <string>
#include <type_traits>
#include <variant>

#include "loopstone/base/byte_archive.hpp"

namespace loopstone {

void LogDigest::add(const SensorMessage& message) {
  ByteWriter writer;
  writer(static_cast<std::uint8_t>(message.index()));
  std::visit(
      [&](const auto& m) {
        if constexpr (std::is_same_v<std::decay_t<decltype(m)>, RgbdFrame>) {
          writer(m.stamp, m.colour_stamp);
        } else {
          writer(m);
        }
      },
      message);
  const std::string bytes = writer.take();
  checksum_ = static_cast<std::uint32_t>(
      ::crc32_z(checksum_, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
  ++messages_;
}

}  // namespace loopstone
