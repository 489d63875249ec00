#include "loopstone/sensor/log_digest.hpp"

#include <fmt/format.h>

#include <type_traits>
#include <variant>

#include "base/crc32.hpp"
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
  checksum_ = crc32_of(writer.take(), checksum_);
  ++messages_;
}

std::string LogDigest::text() const {
  return fmt::format("{} messages, checksum {:08x}", messages_, checksum_);
}

}  // namespace loopstone
