#include "formats/mat_file.hpp"

#include <fmt/format.h>
#include <libdeflate.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <memory>
#include <optional>

#include "formats/cloud_parts.hpp"
#include "formats/scalar_type.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

constexpr std::uint32_t kMatrix = 14;
constexpr std::uint32_t kCompressed = 15;
constexpr std::size_t kHeadBytes = 128;

/// The types of data elements that are numbers; the others have no place inside a numeric matrix.
std::optional<ScalarType> number_type(std::uint32_t type) {
  switch (type) {
    case 1:
      return ScalarType{'i', 1};
    case 2:
      return ScalarType{'u', 1};
    case 3:
      return ScalarType{'i', 2};
    case 4:
      return ScalarType{'u', 2};
    case 5:
      return ScalarType{'i', 4};
    case 6:
      return ScalarType{'u', 4};
    case 7:
      return ScalarType{'f', 4};
    case 9:
      return ScalarType{'f', 8};
    case 12:
      return ScalarType{'i', 8};
    case 13:
      return ScalarType{'u', 8};
    default:
      return std::nullopt;
  }
}

std::string class_name(unsigned array_class) {
  static constexpr std::array<const char*, 6> kNames{"",       "cell array", "struct",
                                                     "object", "text",       "sparse matrix"};
  if (array_class >= 1 && array_class < kNames.size()) return kNames[array_class];
  return "array of class " + std::to_string(array_class);
}

struct Element {
  std::uint32_t type = 0;
  std::string_view data{};
  std::size_t offset = 0;  ///< of the data
};

/// What this file may take, and how much of it is taken by what was read before.
struct Allowance {
  const MemoryBudget& budget;
  std::uint64_t file_bytes = 0;
  std::uint64_t taken_bytes = 0;

  void require(std::uint64_t more_bytes, const Location& where) const {
    budget.require(taken_bytes + more_bytes, file_bytes, Growth::kNumbers, where);
  }
};

/// Cuts bytes into data elements: a tag (type, size), the data, and what fills up to eight bytes.
class Elements {
 public:
  Elements(std::string_view bytes, std::endian order, Location where, std::size_t begin = 0)
      : bytes_(bytes), order_(order), where_(std::move(where)), at_(begin) {}

  [[nodiscard]] bool done() const { return at_ >= bytes_.size(); }

  [[nodiscard]] Element next() {
    if (bytes_.size() - at_ < 8) fail("the file ends within a tag: it was cut off");
    std::uint32_t type = word(at_);
    std::size_t size = word(at_ + 4);
    std::size_t data = at_ + 8;
    if ((type >> 16) != 0) {  // the small format: size, type and up to four bytes in one
      size = type >> 16;
      type &= 0xffffU;
      data = at_ + 4;
      if (size > 4) fail("a small data element has more than 4 bytes: the file is damaged");
    }
    if (size > bytes_.size() - data) {
      fail(fmt::format("an element of {} bytes begins here and {} are left: the file was cut off",
                       size, bytes_.size() - data));
    }
    Element element{type, bytes_.substr(data, size), data};
    // Compressed elements stand without filling.
    at_ = data + size;
    if (type != kCompressed) at_ = std::min((at_ + 7) / 8 * 8, bytes_.size());
    return element;
  }

  /// The one element that there is, as far as it goes: for compressed text matio writes up to eight
  /// bytes more into the tag than follow.
  [[nodiscard]] Element only() const {
    if (bytes_.size() < 8) fail("the file ends within a tag: it was cut off");
    const std::size_t size = word(4);
    return {word(0), bytes_.substr(8, size), 8};
  }

  /// A whole element that must be numbers, as doubles.
  [[nodiscard]] std::vector<double> numbers(const Allowance& allowance) {
    const Element element = next();
    const auto type = number_type(element.type);
    if (!type) fail("numbers were expected here: the file is damaged");
    const auto size = static_cast<std::size_t>(type->bytes);
    allowance.require(bytes_.size() + element.data.size() / size * sizeof(double), where_);
    std::vector<double> values(element.data.size() / size);
    load_scalars(*type, element.data.data(), size, values.size(), order_,
                 [&](std::size_t i, double value) { values[i] = value; });
    return values;
  }

  [[noreturn]] void fail(const std::string& reason) const {
    // Inside a compressed element only the element itself has a place in the file.
    Location here = where_;
    if (!here.byte_offset) here.byte_offset = static_cast<std::int64_t>(at_);
    throw DataError(here, reason);
  }

 private:
  [[nodiscard]] std::uint32_t word(std::size_t at) const {
    return static_cast<std::uint32_t>(load_scalar({'u', 4}, bytes_.data() + at, order_));
  }

  std::string_view bytes_;
  std::endian order_;
  Location where_;
  std::size_t at_;
};

/// What a compressed element holds, when it is no longer than the tag inside promises; by
/// libdeflate, which needs that size beforehand and takes half of zlib's time.
std::optional<std::string> inflate_promised(std::string_view packed, std::endian order,
                                            const Allowance& allowance, const Location& where) {
  constexpr std::size_t kTag = 8;
  constexpr std::size_t kMostExpansion = 1032;  // of Deflate
  std::array<Bytef, kTag> tag{};
  uLongf length = kTag;
  (void)uncompress(tag.data(), &length, reinterpret_cast<const Bytef*>(packed.data()),
                   static_cast<uLong>(packed.size()));
  if (length < kTag) return std::nullopt;
  const auto size = static_cast<std::size_t>(
      load_scalar({'u', 4}, reinterpret_cast<const char*>(tag.data()) + 4, order));
  if (size / kMostExpansion > packed.size()) return std::nullopt;
  allowance.require(kTag + size, where);
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> fast(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  std::string out(kTag + size, '\0');
  std::size_t unpacked = 0;
  if (fast == nullptr ||
      libdeflate_zlib_decompress(fast.get(), packed.data(), packed.size(), out.data(), out.size(),
                                 &unpacked) != LIBDEFLATE_SUCCESS) {
    return std::nullopt;
  }
  out.resize(unpacked);
  return out;
}

/// What a compressed element holds; nothing when it is damaged. Grows with what comes out.
std::optional<std::string> inflate_all(std::string_view packed, const Allowance& allowance,
                                       const Location& where) {
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) throw std::bad_alloc();
  const std::unique_ptr<z_stream, void (*)(z_stream*)> end(
      &stream, [](z_stream* s) { (void)inflateEnd(s); });
  std::string out;
  // zlib promises not to change its input.
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  while (true) {
    const std::size_t before = out.size();
    const std::size_t more = std::clamp<std::size_t>(before, 4096, std::size_t{1} << 24);
    allowance.require(before + more, where);
    out.resize(before + more);
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + before);
    stream.avail_out = static_cast<uInt>(out.size() - before);
    const int status = inflate(&stream, Z_NO_FLUSH);
    out.resize(out.size() - stream.avail_out);
    if (status == Z_STREAM_END) return out;
    if (status != Z_OK || (stream.avail_in == 0 && stream.avail_out != 0)) return std::nullopt;
  }
}

void read_matrix(Elements elements, const Allowance& allowance, MatFile& file) {
  const std::vector<double> flags = elements.numbers(allowance);
  if (flags.empty() || !(flags[0] >= 0.0 && flags[0] < 65536.0)) {
    elements.fail("the flags of an array are missing: the file is damaged");
  }
  const auto word = static_cast<unsigned>(flags[0]);
  const unsigned array_class = word & 0xffU;
  const bool complex = (word & 0x800U) != 0;
  const std::vector<double> sizes = elements.numbers(allowance);
  const std::string name(elements.next().data);
  if (array_class < 6 || array_class > 15) {
    file.others.push_back(name + " (" + class_name(array_class) + ")");
    return;
  }
  if (complex || sizes.size() != 2) {
    file.others.push_back(name +
                          (complex ? " (complex)" : fmt::format(" ({} dimensions)", sizes.size())));
    return;
  }
  std::vector<double> values = elements.numbers(allowance);
  const auto possible = [](double size) { return size >= 0.0 && size <= 1e12; };
  if (!possible(sizes[0]) || !possible(sizes[1]) ||
      sizes[0] * sizes[1] != static_cast<double>(values.size())) {
    elements.fail(fmt::format("{} is said to be {} x {} and holds {} numbers: the file is damaged",
                              show_word(name), sizes[0], sizes[1], values.size()));
  }
  file.matrices.push_back({name, static_cast<std::int64_t>(sizes[0]),
                           static_cast<std::int64_t>(sizes[1]), std::move(values)});
}

std::endian byte_order(std::string_view bytes, const std::string& path) {
  if (bytes.starts_with("\x89HDF\r\n") || bytes.starts_with("MATLAB 7.3")) {
    throw DataError({path},
                    "is a MATLAB file of version 7.3 (HDF5), which is not read; save it with "
                    "-v7");
  }
  if (bytes.size() < kHeadBytes) {
    throw DataError({path, {}, static_cast<std::int64_t>(bytes.size())},
                    "is no MATLAB file of version 5: it ends within the head");
  }
  const std::string_view mark = bytes.substr(126, 2);
  if (mark != "IM" && mark != "MI") {
    throw DataError({path, {}, 126},
                    "is no MATLAB file of version 5: the mark of its byte order is "
                    "missing; save it with -v7");
  }
  return mark == "IM" ? std::endian::little : std::endian::big;
}

}  // namespace

MatFile parse_mat(std::string_view bytes, const std::string& path, const MemoryBudget& budget) {
  const std::endian order = byte_order(bytes, path);
  MatFile file;
  Allowance allowance{budget, bytes.size()};
  Elements top(bytes, order, {path}, kHeadBytes);
  while (!top.done()) {
    const Element element = top.next();
    const Location where{path, {}, static_cast<std::int64_t>(element.offset)};
    allowance.taken_bytes = file.held_bytes();
    if (element.type == kMatrix) {
      read_matrix(Elements(element.data, order, where), allowance, file);
    } else if (element.type == kCompressed) {
      auto inflated = inflate_promised(element.data, order, allowance, where);
      if (!inflated) inflated = inflate_all(element.data, allowance, where);
      if (!inflated) throw DataError(where, "a compressed variable is damaged");
      const Element inner = Elements(*inflated, order, where).only();
      if (inner.type == kMatrix) read_matrix(Elements(inner.data, order, where), allowance, file);
    }
  }
  return file;
}

}  // namespace loopstone
