#include <libdeflate.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <span>

#include "formats/tiff_head.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& reason) {
  throw DataError({path}, "is a damaged TIFF picture: " + reason);
}

/// What is more than a strip needs is of no use, but the checksum behind it is; what is less is
/// missing.
void unpack_deflate_with_rest(std::string_view packed, std::span<char> to,
                              const std::string& path) {
  if (to.size() > std::numeric_limits<uInt>::max()) fail(path, "its Deflate data is broken");
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) throw std::bad_alloc();
  const std::unique_ptr<z_stream, void (*)(z_stream*)> end(
      &stream, [](z_stream* s) { (void)inflateEnd(s); });
  // zlib promises not to change its input.
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(to.data());
  stream.avail_out = static_cast<uInt>(to.size());
  int status = inflate(&stream, Z_NO_FLUSH);
  const std::size_t missing = stream.avail_out;
  std::array<Bytef, 4096> rest;
  while (status == Z_OK && missing == 0) {
    stream.next_out = rest.data();
    stream.avail_out = static_cast<uInt>(rest.size());
    status = inflate(&stream, Z_NO_FLUSH);
  }
  // Z_BUF_ERROR: the data ends before the checksum.
  const bool is_enough = missing == 0 && (status == Z_STREAM_END || status == Z_BUF_ERROR);
  if (!is_enough) fail(path, "its Deflate data is broken or cut off");
}

void unpack_deflate(std::string_view packed, std::span<char> to, const std::string& path) {
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> fast(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  const bool is_unpacked =
      fast != nullptr &&
      libdeflate_zlib_decompress(fast.get(), packed.data(), packed.size(), to.data(), to.size(),
                                 nullptr) == LIBDEFLATE_SUCCESS;
  if (!is_unpacked) unpack_deflate_with_rest(packed, to, path);
}

void unpack_pack_bits(std::string_view packed, std::span<char> to, const std::string& path) {
  std::size_t at = 0;
  while (!to.empty()) {
    if (at >= packed.size()) fail(path, "its PackBits data is cut off");
    const int byte = static_cast<unsigned char>(packed[at++]);
    const int control = byte < 128 ? byte : byte - 256;
    if (control == -128) continue;
    const auto count = static_cast<std::size_t>(control >= 0 ? control + 1 : 1 - control);
    const std::size_t stored = control >= 0 ? count : 1;
    if (packed.size() - at < stored) fail(path, "its PackBits data is cut off");
    const std::size_t used = std::min(count, to.size());
    if (control >= 0) {
      std::memcpy(to.data(), packed.data() + at, used);
    } else {
      std::memset(to.data(), packed[at], used);
    }
    to = to.subspan(used);
    at += stored;
  }
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

/// Where a word of the table stands in what is unpacked already. A strip has less than 2^32 bytes.
struct LzwWord {
  std::uint32_t begin;
  std::uint32_t size;
};

/// Repeats a word at `at`; it may reach into what it writes, which then repeats.
void repeat_word(std::span<char> to, std::size_t at, LzwWord word) {
  constexpr std::size_t kBlock = 8;
  char* out = to.data() + at;
  const char* from = to.data() + word.begin;
  const std::size_t size = std::min<std::size_t>(word.size, to.size() - at);
  // In blocks where what is written too much is written over later.
  if (at - word.begin >= kBlock && to.size() - at >= size + kBlock) {
    for (std::size_t i = 0; i < size; i += kBlock) std::memcpy(out + i, from + i, kBlock);
    return;
  }
  for (std::size_t i = 0; i < size; ++i) out[i] = from[i];
}

void unpack_lzw(std::string_view packed, std::span<char> to, const std::string& path) {
  constexpr std::uint32_t kClear = 256;
  constexpr std::uint32_t kEnd = 257;
  constexpr std::uint32_t kMostWords = 4096;
  // Every word of the table stands in the text already: it is the word before it and the next
  // letter.
  std::array<LzwWord, kMostWords> words;
  std::uint32_t known = kEnd + 1;
  LzwCodes codes(packed);
  LzwWord last{};  // without a size after the table was cleared
  std::size_t at = 0;
  while (at < to.size()) {
    const unsigned width = known < 511 ? 9 : known < 1023 ? 10 : known < 2047 ? 11 : 12;
    const int next = codes.next(width);
    const auto code = static_cast<std::uint32_t>(next);
    if (next < 0 || code == kEnd) fail(path, "its LZW data is cut off");
    if (code == kClear) {
      known = kEnd + 1;
      last = {};
      continue;
    }
    if (last.size > 0) {
      if (known == kMostWords) fail(path, "its LZW data is broken");
      words[known++] = {last.begin, last.size + 1};
    }
    last = {static_cast<std::uint32_t>(at), 1};
    if (code < kClear) {
      to[at] = static_cast<char>(code);
    } else {
      if (code >= known) fail(path, "its LZW data is broken");
      last.size = words[code].size;
      repeat_word(to, at, words[code]);
    }
    at += last.size;
  }
}

}  // namespace

void unpack_tiff(std::string_view packed, TiffPacking packing, std::span<char> to,
                 const std::string& path) {
  switch (packing) {
    case TiffPacking::kLzw:
      return unpack_lzw(packed, to, path);
    case TiffPacking::kDeflate:
      return unpack_deflate(packed, to, path);
    case TiffPacking::kPackBits:
      return unpack_pack_bits(packed, to, path);
    case TiffPacking::kNone:
      break;
  }
  if (packed.size() < to.size()) fail(path, "a strip or tile is cut off");
  std::memcpy(to.data(), packed.data(), to.size());
}

}  // namespace loopstone
