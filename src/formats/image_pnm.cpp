#include <algorithm>
#include <charconv>
#include <cstdint>
#include <string>

#include "formats/picture_size.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/image.hpp"

namespace loopstone {
namespace {

/// Reads whole numbers between white space and comments (# to the end of the line, allowed anywhere
/// before the pixels of a raw file and everywhere in a plain one).
class Tokens {
 public:
  Tokens(std::string_view bytes, std::size_t position, const std::string& path)
      : bytes_(bytes), position_(position), path_(path) {}

  [[nodiscard]] int next_number(const char* what, int most) {
    skip_blanks();
    int value = -1;
    const char* const first = bytes_.data() + position_;
    const auto [end, error] = std::from_chars(first, bytes_.data() + bytes_.size(), value);
    if (error != std::errc{} || value < 0 || value > most) {
      fail(std::string(what) + " should be a whole number from 0 to " + std::to_string(most));
    }
    position_ += static_cast<std::size_t>(end - first);
    return value;
  }

  /// The single white space that ends a raw header.
  void end_header() {
    if (position_ >= bytes_.size() || !is_blank(bytes_[position_]))
      fail("the header does not end in a blank");
    ++position_;
  }

  [[nodiscard]] std::size_t position() const { return position_; }
  [[noreturn]] void fail(const std::string& reason) const {
    throw DataError({path_, {}, static_cast<std::int64_t>(position_)}, reason);
  }

 private:
  static bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

  void skip_blanks() {
    while (position_ < bytes_.size()) {
      if (bytes_[position_] == '#') {
        const std::size_t end = bytes_.find('\n', position_);
        position_ = end == std::string_view::npos ? bytes_.size() : end + 1;
      } else if (is_blank(bytes_[position_])) {
        ++position_;
      } else {
        return;
      }
    }
  }

  std::string_view bytes_;
  std::size_t position_;
  const std::string& path_;
};

void store(Image& image, std::size_t index, int value) {
  if (image.bytes_per_sample == 1) {
    image.bytes[index] = static_cast<std::uint8_t>(value);
  } else {
    const auto wide = static_cast<std::uint16_t>(value);
    std::memcpy(image.bytes.data() + 2 * index, &wide, sizeof wide);
  }
}

}  // namespace

Image decode_pnm(std::string_view bytes, const std::string& path_for_errors,
                 const MemoryBudget& budget) {
  if (bytes.size() < 2 || bytes[0] != 'P' ||
      std::string_view("2356").find(bytes[1]) == std::string_view::npos) {
    throw DataError({path_for_errors},
                    "is no PGM picture; expected P2 or P5 (or P3, P6 for colour) at its beginning");
  }
  const bool plain = bytes[1] == '2' || bytes[1] == '3';
  Tokens tokens(bytes, 2, path_for_errors);
  const int width = tokens.next_number("the width", static_cast<int>(kMostPictureSide));
  const int height = tokens.next_number("the height", static_cast<int>(kMostPictureSide));
  const int max_value = tokens.next_number("the largest value", 65535);
  if (width == 0 || height == 0 || max_value == 0)
    tokens.fail("width, height and largest value must not be 0");
  if (!plain) tokens.end_header();

  const int channels = bytes[1] == '2' || bytes[1] == '5' ? 1 : 3;
  const int bytes_per_sample = max_value < 256 ? 1 : 2;
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  const std::size_t samples = pixels * static_cast<std::size_t>(channels);
  // A plain sample takes a digit and a blank, the last one perhaps no blank.
  const std::size_t least_bytes =
      plain ? 2 * samples - 1 : samples * static_cast<std::size_t>(bytes_per_sample);
  if (bytes.size() - tokens.position() < least_bytes) {
    tokens.fail("the file ends too early: " + std::to_string(width) + " x " +
                std::to_string(height) + " pixels need at least " + std::to_string(least_bytes) +
                " bytes, " + std::to_string(bytes.size() - tokens.position()) + " are left");
  }

  require_picture(static_cast<std::uint64_t>(width), static_cast<std::uint64_t>(height),
                  static_cast<std::uint64_t>(channels * bytes_per_sample), bytes.size(), budget,
                  {path_for_errors});
  Image image = make_image(width, height, channels, bytes_per_sample);
  image.max_value = max_value;
  const auto* const raw = reinterpret_cast<const std::uint8_t*>(bytes.data()) + tokens.position();
  for (std::size_t i = 0; i < samples; ++i) {
    int value = 0;
    if (plain) {
      value = tokens.next_number("a pixel", max_value);
    } else if (bytes_per_sample == 1) {
      value = raw[i];
    } else {
      value = raw[2 * i] * 256 + raw[2 * i + 1];
    }
    store(image, i, std::min(value, max_value));
  }
  return image;
}

std::string encode_pgm(const Image& image) {
  if (image.channels != 1 || image.bytes_per_sample != 1)
    throw UsageError("a PGM holds one channel of 8 bits");
  std::string text =
      "P5\n" + std::to_string(image.width) + " " + std::to_string(image.height) + "\n255\n";
  text.append(reinterpret_cast<const char*>(image.bytes.data()), image.bytes.size());
  return text;
}

}  // namespace loopstone
