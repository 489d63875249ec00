#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include "formats/float_image.hpp"
#include "formats/picture_size.hpp"
#include "formats/text_numbers.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

constexpr auto kMostSide = static_cast<std::int64_t>(kMostPictureSide);

struct PfmHead {
  int width = 0;
  int height = 0;
  std::endian order = std::endian::little;
  std::size_t size = 0;
};

/// Three words after "Pf", and a single blank that ends the head.
class PfmWords {
 public:
  PfmWords(std::string_view bytes, const std::string& path) : bytes_(bytes), path_(path) {}

  std::string_view next(const char* what) {
    while (at_ < bytes_.size() && is_blank(bytes_[at_])) ++at_;
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && !is_blank(bytes_[at_])) ++at_;
    constexpr std::size_t kLongest = 40;
    if (at_ == begin || at_ - begin > kLongest || at_ == bytes_.size()) {
      fail(std::string("the file ends before ") + what);
    }
    return bytes_.substr(begin, at_ - begin);
  }
  int side(const char* what) {
    const auto number = parse_integer(next(what));
    if (!number || *number < 1 || *number > kMostSide) {
      fail(std::string(what) + " should be a whole number from 1 to " + std::to_string(kMostSide));
    }
    return static_cast<int>(*number);
  }
  [[nodiscard]] std::size_t end_of_head() const { return at_ + 1; }
  [[noreturn]] void fail(const std::string& reason) const {
    throw DataError({path_, {}, static_cast<std::int64_t>(at_)}, reason);
  }

 private:
  static bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

  std::string_view bytes_;
  const std::string& path_;
  std::size_t at_ = 2;
};

PfmHead parse_head(std::string_view bytes, const std::string& path) {
  if (!bytes.starts_with("Pf")) {
    throw DataError({path}, bytes.starts_with("PF")
                                ? "is a PFM picture with three channels; depth has one (Pf)"
                                : "is no PFM picture; expected Pf at its beginning");
  }
  PfmWords words(bytes, path);
  PfmHead head;
  head.width = words.side("the width");
  head.height = words.side("the height");
  const auto scale = parse_number(words.next("the scale"));
  if (!scale || std::abs(*scale) != 1.0) {
    words.fail(
        "the scale should be -1 (little endian) or 1 (big endian); store metres as they are");
  }
  head.order = *scale < 0.0 ? std::endian::little : std::endian::big;
  head.size = words.end_of_head();
  return head;
}

}  // namespace

FloatImage decode_pfm(std::string_view bytes, const std::string& path_for_errors,
                      const MemoryBudget& budget) {
  const PfmHead head = parse_head(bytes, path_for_errors);
  const auto width = static_cast<std::size_t>(head.width);
  const auto height = static_cast<std::size_t>(head.height);
  const std::size_t left = bytes.size() - head.size;
  if (left < width * height * sizeof(float)) {
    throw DataError({path_for_errors, {}, static_cast<std::int64_t>(head.size)},
                    "the file ends too early: " + std::to_string(width) + " x " +
                        std::to_string(height) + " pixels need " +
                        std::to_string(width * height * sizeof(float)) + " bytes, " +
                        std::to_string(left) + " are left");
  }
  require_picture(width, height, sizeof(float), bytes.size(), budget, {path_for_errors});
  FloatImage image{head.width, head.height, std::vector<float>(width * height)};
  for (std::size_t row = 0; row < height; ++row) {
    // The bottom row comes first.
    std::memcpy(&image.values[(height - 1 - row) * width],
                bytes.data() + head.size + row * width * sizeof(float), width * sizeof(float));
  }
  if (head.order != std::endian::native) {
    for (float& value : image.values) {
      std::uint32_t bits = std::bit_cast<std::uint32_t>(value);
      bits = (bits >> 24U) | ((bits >> 8U) & 0xff00U) | ((bits & 0xff00U) << 8U) | (bits << 24U);
      value = std::bit_cast<float>(bits);
    }
  }
  return image;
}

}  // namespace loopstone
