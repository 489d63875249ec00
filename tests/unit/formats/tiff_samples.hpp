#pragma once

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace loopstone::test {

enum class TiffSamplePacking { kNone = 1, kLzw = 5, kDeflate = 8, kPackBits = 32773 };

/// How a TIFF file stores its picture. Written after Adobe's TIFF revision 6.0, apart from the
/// reader.
struct TiffLayout {
  std::endian order = std::endian::little;
  TiffSamplePacking packing = TiffSamplePacking::kNone;
  int predictor = 1;
  std::size_t rows_per_strip = 2;
  std::size_t tile = 0;  ///< side of square tiles; 0: strips

  [[nodiscard]] std::string text() const {
    return std::string(order == std::endian::little ? "II" : "MM") + " compression " +
           std::to_string(static_cast<int>(packing)) + " predictor " + std::to_string(predictor) +
           (tile > 0 ? " tiles" : " strips");
  }
};

inline std::vector<TiffLayout> all_layouts(const std::vector<int>& predictors) {
  std::vector<TiffLayout> layouts;
  for (const auto order : {std::endian::little, std::endian::big}) {
    for (const auto packing : {TiffSamplePacking::kNone, TiffSamplePacking::kLzw,
                               TiffSamplePacking::kDeflate, TiffSamplePacking::kPackBits}) {
      for (const int predictor : predictors) {
        for (const std::size_t tile : {std::size_t{0}, std::size_t{16}}) {
          layouts.push_back({order, packing, predictor, 2, tile});
        }
      }
    }
  }
  return layouts;
}
inline std::vector<TiffLayout> all_float_layouts() { return all_layouts({1, 2, 3}); }
inline std::vector<TiffLayout> all_number_layouts() { return all_layouts({1, 2}); }

inline void append_number(std::string& bytes, std::uint32_t value, std::size_t size,
                          std::endian order) {
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t shift = 8 * (order == std::endian::little ? i : size - 1 - i);
    bytes += static_cast<char>((value >> shift) & 0xffU);
  }
}

inline std::string pack_lzw(std::string_view plain) {
  std::string packed;
  std::uint64_t bits = 0;
  unsigned held = 0;
  std::map<std::string, unsigned> table;
  const auto reset = [&] {
    table.clear();
    for (unsigned i = 0; i < 256; ++i) table[std::string(1, static_cast<char>(i))] = i;
  };
  unsigned next = 258;
  const auto put = [&](unsigned code) {
    // The writer is one word ahead of the reader: it changes the width when it has added word 511,
    // 1023, 2047.
    const unsigned width = next <= 511 ? 9 : next <= 1023 ? 10 : next <= 2047 ? 11 : 12;
    bits = (bits << width) | code;
    held += width;
    while (held >= 8) {
      held -= 8;
      packed += static_cast<char>((bits >> held) & 0xffU);
    }
  };
  reset();
  put(256);
  std::string word;
  for (const char letter : plain) {
    if (table.contains(word + letter)) {
      word += letter;
      continue;
    }
    put(table.at(word));
    table[word + letter] = next++;
    word = letter;
    if (next == 4095) {
      put(table.at(word));
      word.clear();
      put(256);
      next = 258;
      reset();
    }
  }
  if (!word.empty()) {
    put(table.at(word));
    ++next;
  }
  put(257);
  if (held > 0) packed += static_cast<char>((bits << (8 - held)) & 0xffU);
  return packed;
}

inline std::string pack_bits(std::string_view plain) {
  std::string packed;
  for (std::size_t at = 0; at < plain.size();) {
    std::size_t run = 1;
    while (run < 128 && at + run < plain.size() && plain[at + run] == plain[at]) ++run;
    if (run > 2) {
      packed += static_cast<char>(1 - static_cast<int>(run));
      packed += plain[at];
    } else {
      run = std::min<std::size_t>(5, plain.size() - at);
      packed += static_cast<char>(run - 1);
      packed += plain.substr(at, run);
    }
    at += run;
  }
  return packed;
}

inline std::string pack_tiff(const std::string& plain, TiffSamplePacking packing) {
  if (packing == TiffSamplePacking::kNone) return plain;
  if (packing == TiffSamplePacking::kLzw) return pack_lzw(plain);
  if (packing == TiffSamplePacking::kPackBits) return pack_bits(plain);
  uLongf size = compressBound(static_cast<uLong>(plain.size()));
  std::string packed(size, '\0');
  if (compress(reinterpret_cast<Bytef*>(packed.data()), &size,
               reinterpret_cast<const Bytef*>(plain.data()),
               static_cast<uLong>(plain.size())) != Z_OK) {
    throw std::runtime_error("compress");
  }
  packed.resize(size);
  return packed;
}

/// The bits of a row, its predictor applied, in the byte order of the file.
template <typename Sample>
std::string encode_tiff_row(const std::vector<Sample>& samples, const TiffLayout& layout) {
  using Bits = std::conditional_t<sizeof(Sample) == 4, std::uint32_t, std::uint16_t>;
  std::vector<Bits> bits;
  for (const Sample sample : samples) bits.push_back(std::bit_cast<Bits>(sample));
  std::string row;
  if (layout.predictor == 3) {
    for (int byte = static_cast<int>(sizeof(Bits)) - 1; byte >= 0; --byte) {
      for (const Bits value : bits) row += static_cast<char>((value >> (8 * byte)) & 0xffU);
    }
    for (std::size_t i = row.size(); i-- > 1;) row[i] = static_cast<char>(row[i] - row[i - 1]);
    return row;
  }
  if (layout.predictor == 2) {
    for (std::size_t i = bits.size(); i-- > 1;) bits[i] = static_cast<Bits>(bits[i] - bits[i - 1]);
  }
  for (const Bits value : bits) append_number(row, value, sizeof value, layout.order);
  return row;
}

struct TiffEntry {
  unsigned tag = 0;
  unsigned type = 0;
  std::uint32_t count = 1;
  std::uint32_t value = 0;
};

/// Rows and columns of a strip or tile.
struct TiffPart {
  std::size_t down = 0;
  std::size_t across = 0;
};

/// The samples of a picture, packed in strips or tiles, and where each of them begins in the file.
struct TiffData {
  std::string bytes{};
  std::vector<std::uint32_t> offsets{};
  std::vector<std::uint32_t> sizes{};

  /// Where a list of these stands, or the one value of it.
  [[nodiscard]] std::uint32_t put(const std::vector<std::uint32_t>& values, std::endian order) {
    const auto at = static_cast<std::uint32_t>(8 + bytes.size());
    for (const std::uint32_t value : values) append_number(bytes, value, 4, order);
    return values.size() == 1 ? values[0] : at;
  }
};

template <typename Sample>
TiffData tiff_data(const std::vector<Sample>& top_down, std::size_t rows, std::size_t columns,
                   const TiffPart& part, const TiffLayout& layout) {
  TiffData data;
  for (std::size_t top = 0; top < rows; top += part.down) {
    for (std::size_t left = 0; left < columns; left += part.across) {
      std::string plain;
      const std::size_t end = layout.tile > 0 ? top + part.down : std::min(top + part.down, rows);
      for (std::size_t row = top; row < end; ++row) {
        std::vector<Sample> samples(part.across);
        for (std::size_t i = 0; i < part.across && row < rows && left + i < columns; ++i) {
          samples[i] = top_down[row * columns + left + i];
        }
        plain += encode_tiff_row(samples, layout);
      }
      const std::string packed = pack_tiff(plain, layout.packing);
      data.offsets.push_back(static_cast<std::uint32_t>(8 + data.bytes.size()));
      data.sizes.push_back(static_cast<std::uint32_t>(packed.size()));
      data.bytes += packed;
    }
  }
  return data;
}

inline std::string tiff_file(const std::string& data, const std::vector<TiffEntry>& entries,
                             std::endian order) {
  std::string bytes = order == std::endian::little ? "II" : "MM";
  append_number(bytes, 42, 2, order);
  append_number(bytes, static_cast<std::uint32_t>(8 + data.size()), 4, order);
  bytes += data;
  append_number(bytes, static_cast<std::uint32_t>(entries.size()), 2, order);
  for (const TiffEntry& entry : entries) {
    append_number(bytes, entry.tag, 2, order);
    append_number(bytes, entry.type, 2, order);
    append_number(bytes, entry.count, 4, order);
    const bool is_short = entry.type == 3;
    append_number(bytes, entry.value, is_short ? 2 : 4, order);
    if (is_short) append_number(bytes, 0, 2, order);
  }
  append_number(bytes, 0, 4, order);
  return bytes;
}

template <typename Sample>
std::string make_tiff(const std::vector<Sample>& top_down, int width, const TiffLayout& layout) {
  const auto columns = static_cast<std::size_t>(width);
  const std::size_t rows = top_down.size() / columns;
  const TiffPart part{.down = layout.tile > 0 ? layout.tile : layout.rows_per_strip,
                      .across = layout.tile > 0 ? layout.tile : columns};
  TiffData data = tiff_data(top_down, rows, columns, part, layout);
  const auto count = static_cast<std::uint32_t>(data.offsets.size());
  const std::uint32_t offsets_at = data.put(data.offsets, layout.order);
  const std::uint32_t sizes_at = data.put(data.sizes, layout.order);
  std::vector<TiffEntry> entries{
      {256, 4, 1, static_cast<std::uint32_t>(columns)},
      {257, 4, 1, static_cast<std::uint32_t>(rows)},
      {258, 3, 1, 8 * sizeof(Sample)},
      {259, 3, 1, static_cast<std::uint32_t>(layout.packing)},
      {262, 3, 1, 1},
  };
  if (layout.tile == 0) {
    entries.push_back({273, 4, count, offsets_at});
    entries.push_back({277, 3, 1, 1});
    entries.push_back({278, 4, 1, static_cast<std::uint32_t>(part.down)});
    entries.push_back({279, 4, count, sizes_at});
  }
  entries.push_back({317, 3, 1, static_cast<std::uint32_t>(layout.predictor)});
  if (layout.tile > 0) {
    entries.push_back({322, 3, 1, static_cast<std::uint32_t>(part.across)});
    entries.push_back({323, 3, 1, static_cast<std::uint32_t>(part.down)});
    entries.push_back({324, 4, count, offsets_at});
    entries.push_back({325, 4, count, sizes_at});
  }
  entries.push_back({339, 3, 1, sizeof(Sample) == 4 ? 3U : 1U});
  return tiff_file(data.bytes, entries, layout.order);
}

}  // namespace loopstone::test
