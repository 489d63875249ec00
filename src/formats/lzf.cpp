#include "formats/lzf.hpp"

namespace loopstone {

// The stream is a row of runs. A first byte below 32 announces that many plus one literal bytes.
// Any other is a copy of earlier output: its upper three bits are the length less 2 (7: a further
// byte adds to it), its lower five and the byte that follows the distance less 1.
std::optional<std::string> lzf_decompress(std::string_view packed, std::size_t size) {
  constexpr std::size_t kMostFromThreeBytes = 264;
  if (size / kMostFromThreeBytes > packed.size() / 3 + 1) return std::nullopt;
  std::string out;
  out.reserve(size);
  std::size_t at = 0;
  const auto byte = [&packed](std::size_t i) {
    return static_cast<std::size_t>(static_cast<unsigned char>(packed[i]));
  };
  while (at < packed.size()) {
    const std::size_t control = byte(at++);
    if (control < 32) {
      const std::size_t count = control + 1;
      if (count > packed.size() - at || count > size - out.size()) return std::nullopt;
      out.append(packed, at, count);
      at += count;
      continue;
    }
    std::size_t count = control >> 5;
    if (count == 7) {
      if (at == packed.size()) return std::nullopt;
      count += byte(at++);
    }
    count += 2;
    if (at == packed.size()) return std::nullopt;
    const std::size_t distance = ((control & 31U) << 8 | byte(at++)) + 1;
    if (distance > out.size() || count > size - out.size()) return std::nullopt;
    // Byte by byte: source and destination may overlap, which repeats a pattern.
    for (std::size_t i = 0; i < count; ++i) out += out[out.size() - distance];
  }
  if (out.size() != size) return std::nullopt;
  return out;
}

}  // namespace loopstone
