#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "formats/tiff_head.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& reason) {
  throw DataError({path}, "is a damaged TIFF picture: " + reason);
}

std::string unpack_deflate(std::string_view packed, std::size_t size, const std::string& path) {
  std::string plain(size, '\0');
  auto length = static_cast<uLongf>(size);
  const int status =
      uncompress(reinterpret_cast<Bytef*>(plain.data()), &length,
                 reinterpret_cast<const Bytef*>(packed.data()), static_cast<uLong>(packed.size()));
  // What is more than a strip needs is of no use; what is less is missing.
  const bool is_enough = (status == Z_OK || status == Z_BUF_ERROR) && length == size;
  if (!is_enough) fail(path, "its Deflate data is broken or cut off");
  return plain;
}

std::string unpack_pack_bits(std::string_view packed, std::size_t size, const std::string& path) {
  std::string plain;
  plain.reserve(size);
  std::size_t at = 0;
  while (plain.size() < size) {
    if (at >= packed.size()) fail(path, "its PackBits data is cut off");
    const int byte = static_cast<unsigned char>(packed[at++]);
    const int control = byte < 128 ? byte : byte - 256;
    if (control == -128) continue;
    const auto count = static_cast<std::size_t>(control >= 0 ? control + 1 : 1 - control);
    const std::size_t stored = control >= 0 ? count : 1;
    if (packed.size() - at < stored) fail(path, "its PackBits data is cut off");
    const std::size_t used = std::min(count, size - plain.size());
    if (control >= 0) {
      plain.append(packed.substr(at, used));
    } else {
      plain.append(used, packed[at]);
    }
    at += stored;
  }
  return plain;
}

/// Codes of 9 to 12 bits, first bit first; the width grows one code early (TIFF revision 6.0,
/// section 13).
class LzwCodes {
 public:
  explicit LzwCodes(std::string_view packed) : packed_(packed) {}

  /// -1 at the end.
  int next(unsigned width) {
    while (held_ < width) {
      if (at_ == packed_.size()) return -1;
      bits_ = (bits_ << 8U) | static_cast<std::uint8_t>(packed_[at_++]);
      held_ += 8;
    }
    held_ -= width;
    return static_cast<int>((bits_ >> held_) & ((1U << width) - 1U));
  }

 private:
  std::string_view packed_;
  std::size_t at_ = 0;
  std::uint32_t bits_ = 0;
  unsigned held_ = 0;
};

std::string unpack_lzw(std::string_view packed, std::size_t size, const std::string& path) {
  constexpr int kClear = 256;
  constexpr int kEnd = 257;
  constexpr std::size_t kMostWords = 4096;
  // Every word of the table stands in the text already: it is the word before it and the next
  // letter.
  std::vector<TiffSpan> words;
  words.reserve(kMostWords);
  const auto clear = [&] { words.assign(kEnd + 1, TiffSpan{}); };
  clear();
  std::string plain;
  plain.reserve(size);
  LzwCodes codes(packed);
  TiffSpan last{};
  bool has_last = false;
  while (plain.size() < size) {
    const std::size_t known = words.size();
    const unsigned width = known < 511 ? 9 : known < 1023 ? 10 : known < 2047 ? 11 : 12;
    const int code = codes.next(width);
    if (code < 0 || code == kEnd) fail(path, "its LZW data is cut off");
    if (code == kClear) {
      clear();
      has_last = false;
      continue;
    }
    const TiffSpan here{plain.size(), 0};
    if (has_last) {
      if (words.size() == kMostWords) fail(path, "its LZW data is broken");
      words.push_back({last.offset, last.size + 1});
    }
    if (code < kClear) {
      plain.push_back(static_cast<char>(code));
    } else {
      if (static_cast<std::size_t>(code) >= words.size()) fail(path, "its LZW data is broken");
      const TiffSpan word = words[static_cast<std::size_t>(code)];
      // Letter by letter: a word may reach into what it writes.
      for (std::size_t i = 0; i < word.size; ++i) plain.push_back(plain[word.offset + i]);
    }
    last = {here.offset, plain.size() - here.offset};
    has_last = true;
  }
  plain.resize(size);
  return plain;
}

}  // namespace

std::string unpack_tiff(std::string_view packed, TiffPacking packing, std::size_t size,
                        const std::string& path) {
  switch (packing) {
    case TiffPacking::kLzw:
      return unpack_lzw(packed, size, path);
    case TiffPacking::kDeflate:
      return unpack_deflate(packed, size, path);
    case TiffPacking::kPackBits:
      return unpack_pack_bits(packed, size, path);
    case TiffPacking::kNone:
      break;
  }
  if (packed.size() < size) fail(path, "a strip or tile is cut off");
  return std::string(packed.substr(0, size));
}

}  // namespace loopstone
