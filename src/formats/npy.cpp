#include "formats/npy.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "formats/npy_head.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

static_assert(std::endian::native == std::endian::little,
              "little-endian numbers are copied as they stand in the file");

constexpr std::size_t kBlockElements = 8192;

/// IEEE 754 binary16.
double half_to_double(std::uint16_t bits) {
  const int exponent = (bits >> 10) & 0x1f;
  const int mantissa = bits & 0x3ff;
  const double sign = (bits & 0x8000) != 0 ? -1.0 : 1.0;
  if (exponent == 0) return sign * std::ldexp(mantissa, -24);
  if (exponent == 31) return mantissa == 0 ? sign * HUGE_VAL : std::nan("");
  return sign * std::ldexp(mantissa + 1024, exponent - 25);
}

template <typename Stored, typename T>
void convert(const char* bytes, std::span<T> values) {
  for (T& value : values) {
    Stored stored;
    std::memcpy(&stored, bytes, sizeof stored);
    bytes += sizeof stored;
    value = static_cast<T>(stored);
  }
}

/// Turns the bytes of every element round.
void reverse_each(std::span<char> bytes, std::size_t element_bytes) {
  const auto size = static_cast<std::ptrdiff_t>(element_bytes);
  for (auto at = bytes.begin(); at != bytes.end(); at += size) std::reverse(at, at + size);
}

template <typename T>
void convert_half(const char* bytes, std::span<T> values) {
  for (T& value : values) {
    std::uint16_t stored;
    std::memcpy(&stored, bytes, sizeof stored);
    bytes += sizeof stored;
    value = static_cast<T>(half_to_double(stored));
  }
}

template <typename T>
void convert_block(const NpyHeader& header, const char* bytes, std::span<T> values) {
  const int size = header.element_bytes;
  if (header.kind == 'f') {
    if (size == 8) return convert<double>(bytes, values);
    if (size == 4) return convert<float>(bytes, values);
    return convert_half(bytes, values);
  }
  if (header.kind == 'i') {
    if (size == 8) return convert<std::int64_t>(bytes, values);
    if (size == 4) return convert<std::int32_t>(bytes, values);
    if (size == 2) return convert<std::int16_t>(bytes, values);
    return convert<std::int8_t>(bytes, values);
  }
  if (size == 8) return convert<std::uint64_t>(bytes, values);
  if (size == 4) return convert<std::uint32_t>(bytes, values);
  if (size == 2) return convert<std::uint16_t>(bytes, values);
  return convert<std::uint8_t>(bytes, values);
}

}  // namespace

NpyReader::NpyReader(std::unique_ptr<ByteSource> source, std::string name)
    : source_(std::move(source)), name_(std::move(name)) {
  parse_head();
}

void NpyReader::fill(std::span<char> bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const std::size_t count = source_->read(bytes.subspan(done));
    if (count == 0) {
      throw DataError({name_, {}, offset_ + static_cast<std::int64_t>(done)},
                      "the array ends too early: the file was cut off");
    }
    done += count;
  }
  offset_ += static_cast<std::int64_t>(bytes.size());
}

void NpyReader::parse_head() {
  std::array<char, 8> magic{};
  fill(magic);
  if (std::memcmp(magic.data(), "\x93NUMPY", 6) != 0) {
    throw DataError({name_, {}, 0}, "is no NumPy array: it doesn't begin with \\x93NUMPY");
  }
  const int version = static_cast<unsigned char>(magic[6]);
  if (version < 1 || version > 3) {
    throw DataError({name_, {}, 6}, "is of .npy version " + std::to_string(version) +
                                        "; versions 1, 2 and 3 are read");
  }
  std::array<char, 4> length_bytes{};
  fill(std::span(length_bytes).first(version == 1 ? 2 : 4));
  std::uint32_t length = 0;
  std::memcpy(&length, length_bytes.data(), 4);
  if (length > (1U << 20)) {
    throw DataError({name_, {}, 8}, "the head of the array would be longer than a megabyte");
  }
  const Location where{name_, {}, offset_};
  std::string dict(length, '\0');
  fill(dict);
  header_ = parse_npy_dict(dict, where);
}

template <typename T>
void NpyReader::read_as(std::span<T> values) {
  const auto size = static_cast<std::size_t>(header_.element_bytes);
  if (header_.kind == 'f' && size == sizeof(T) && !header_.big_endian) {
    return fill({reinterpret_cast<char*>(values.data()), values.size_bytes()});
  }
  std::array<char, kBlockElements * 8> block;
  while (!values.empty()) {
    const std::size_t count = std::min(values.size(), kBlockElements);
    fill(std::span(block).first(count * size));
    if (header_.big_endian) reverse_each(std::span(block).first(count * size), size);
    convert_block(header_, block.data(), values.first(count));
    values = values.subspan(count);
  }
}

void NpyReader::read(std::span<double> values) { read_as(values); }
void NpyReader::read(std::span<float> values) { read_as(values); }

NpyArray read_npy(std::unique_ptr<ByteSource> source, const std::string& name,
                  const MemoryBudget& budget, std::optional<std::uint64_t> file_bytes) {
  const std::uint64_t stored =
      file_bytes.value_or(static_cast<std::uint64_t>(source->bytes_total()));
  NpyReader reader(std::move(source), name);
  const NpyHeader& header = reader.header();
  if (header.shape.size() > 2) {
    throw DataError({name}, "has " + std::to_string(header.shape.size()) +
                                " dimensions, at most 2 were expected");
  }
  NpyArray array{header.shape, header.fortran_order, {}};
  const auto count = static_cast<std::size_t>(header.count());
  budget.require(saturated_product(count, sizeof(double)), stored, Growth::kNumbers, {name});
  array.values.reserve(count);
  while (array.values.size() < count) {
    const std::size_t begin = array.values.size();
    array.values.resize(std::min(count, begin + kBlockElements));
    reader.read(std::span(array.values).subspan(begin));
  }
  return array;
}

}  // namespace loopstone
