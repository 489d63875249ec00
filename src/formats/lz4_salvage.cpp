#include "formats/lz4_salvage.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "formats/little_endian.hpp"

namespace loopstone {
namespace {

/// The bytes of a block that are still to be read.
struct Packed {
  const unsigned char* at;
  const unsigned char* end;

  [[nodiscard]] std::size_t left() const { return static_cast<std::size_t>(end - at); }
};

/// A length of four bits, and the bytes that add to it. False when they are cut off.
bool read_length(Packed& in, std::size_t nibble, std::size_t& length) {
  length = nibble;
  if (nibble != 15) return true;
  while (in.at < in.end) {
    const std::size_t more = *in.at++;
    length += more;
    if (more != 255) return true;
  }
  return false;
}

}  // namespace

SalvagedBlock salvage_lz4_block(std::string_view packed, char* out, std::size_t used,
                                std::size_t capacity) {
  Packed in{reinterpret_cast<const unsigned char*>(packed.data()),
            reinterpret_cast<const unsigned char*>(packed.data()) + packed.size()};
  while (in.at < in.end && used < capacity) {
    const std::size_t token = *in.at++;
    std::size_t length = 0;
    if (!read_length(in, token >> 4U, length)) break;
    const std::size_t literals = std::min({length, in.left(), capacity - used});
    std::memcpy(out + used, in.at, literals);
    used += literals;
    in.at += literals;
    if (in.at == in.end) return {used, literals == length};
    if (literals < length || in.left() < 2) break;
    const std::size_t distance = in.at[0] + (std::size_t{in.at[1]} << 8U);
    in.at += 2;
    if (distance == 0 || distance > used || !read_length(in, token & 15U, length)) break;
    const std::size_t end = used + std::min(length + 4, capacity - used);
    for (; used < end; ++used) out[used] = out[used - distance];
  }
  return {used, false};
}

std::size_t salvage_lz4_frame(std::string_view packed, char* out, std::size_t capacity) {
  constexpr std::size_t kMagicBytes = 4;
  constexpr std::size_t kLeastHead = 3;  // flags, size of blocks, checksum
  if (packed.size() < kMagicBytes + kLeastHead) return 0;
  const auto flags = static_cast<unsigned char>(packed[kMagicBytes]);
  const std::size_t content_size = (flags & 8U) != 0 ? 8 : 0;
  const std::size_t dictionary = (flags & 1U) != 0 ? 4 : 0;
  const std::size_t block_checksum = (flags & 16U) != 0 ? 4 : 0;
  std::size_t at = kMagicBytes + kLeastHead + content_size + dictionary;
  std::size_t used = 0;
  while (at + 4 <= packed.size() && used < capacity) {
    const auto word = little_endian<std::uint32_t>(packed.data() + at);
    at += 4;
    if (word == 0) break;
    const bool is_packed = (word >> 31U) == 0;
    const std::size_t size = word & 0x7fffffffU;
    const std::string_view block = packed.substr(at, size);
    if (is_packed) {
      const SalvagedBlock made = salvage_lz4_block(block, out, used, capacity);
      used = made.used;
      if (!made.is_whole) break;
    } else {
      const std::size_t count = std::min(block.size(), capacity - used);
      std::memcpy(out + used, block.data(), count);
      used += count;
    }
    if (block.size() < size) break;
    at = std::min(packed.size(), at + size + block_checksum);
  }
  return used;
}

}  // namespace loopstone
