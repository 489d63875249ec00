#include "formats/packed_record.hpp"

#include <zstd.h>

#include <cstring>
#include <stdexcept>

#include "base/crc32.hpp"
#include "formats/zstd_unpack.hpp"

namespace loopstone {

namespace {

constexpr int kLevel = 3;
constexpr std::size_t kHead = 4;  ///< the checksum, little-endian
constexpr std::uint64_t kMostBytes = std::uint64_t{4} << 30U;

}  // namespace

std::string pack_record(std::string_view bytes) {
  std::string packed(kHead + ZSTD_compressBound(bytes.size()), '\0');
  const std::uint32_t checksum = crc32_of(bytes);
  for (std::size_t i = 0; i < kHead; ++i)
    packed[i] = static_cast<char>(checksum >> (8 * i) & 0xFFU);
  const std::size_t size = ZSTD_compress(packed.data() + kHead, packed.size() - kHead, bytes.data(),
                                         bytes.size(), kLevel);
  if (ZSTD_isError(size) != 0) throw std::runtime_error(ZSTD_getErrorName(size));
  packed.resize(kHead + size);
  return packed;
}

std::string unpack_record(std::span<const char> packed) {
  if (packed.size() < kHead) throw std::runtime_error("it is cut off");
  std::uint32_t checksum = 0;
  for (std::size_t i = 0; i < kHead; ++i)
    checksum |= static_cast<std::uint32_t>(static_cast<unsigned char>(packed[i])) << (8 * i);
  std::string bytes;
  ZstdUnpacker().unpack(packed.subspan(kHead), kMostBytes, bytes);
  if (crc32_of(bytes) != checksum) throw std::runtime_error("its checksum is wrong");
  return bytes;
}

}  // namespace loopstone
