#include <png.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "formats/atomic_file.hpp"
#include "formats/png_guard.hpp"
#include "formats/png_rows.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/image.hpp"

namespace loopstone {
namespace {

class Writer {
 public:
  Writer()
      : png_(
            png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, on_png_error, on_png_warning)) {
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
    if (info_ == nullptr) throw std::bad_alloc();
  }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  ~Writer() { png_destroy_write_struct(&png_, &info_); }

  [[nodiscard]] png_structp png() const { return png_; }
  [[nodiscard]] png_infop info() const { return info_; }

 private:
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

void append_bytes(png_structp png, png_bytep from, std::size_t count) {
  static_cast<std::string*>(png_get_io_ptr(png))
      ->append(reinterpret_cast<const char*>(from), count);
}

int colour_type_of(int channels) {
  constexpr int kTypes[] = {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB,
                            PNG_COLOR_TYPE_RGB_ALPHA};
  return kTypes[channels - 1];
}

/// Writes the head; the bytes come to `encoded`.
bool begin(Writer& writer, std::string& encoded, const Image& head, int compression) {
  return guarded(writer.png(), [&] {
    png_set_write_fn(writer.png(), &encoded, append_bytes, nullptr);
    png_set_user_limits(writer.png(), 0x7fffffff, 0x7fffffff);
    png_set_compression_level(writer.png(), compression);
    // Maps are flat areas: guessing the best filter for each row costs more time than it saves
    // bytes.
    png_set_filter(writer.png(), 0, compression < 6 ? PNG_FILTER_SUB : PNG_ALL_FILTERS);
    png_set_IHDR(writer.png(), writer.info(), static_cast<png_uint_32>(head.width),
                 static_cast<png_uint_32>(head.height), 8 * head.bytes_per_sample,
                 colour_type_of(head.channels), PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_write_info(writer.png(), writer.info());
    if (head.bytes_per_sample == 2 && std::endian::native == std::endian::little) {
      png_set_swap(writer.png());
    }
  });
}

[[noreturn]] void fail(int width, int height) {
  throw std::runtime_error("a picture of " + std::to_string(width) + " x " +
                           std::to_string(height) + " pixels could not be encoded as PNG");
}

}  // namespace

std::string encode_png(const Image& image, int compression) {
  Writer writer;
  std::string encoded;
  const std::size_t stride = image.bytes.size() / static_cast<std::size_t>(image.height);
  if (!begin(writer, encoded, image, compression)) fail(image.width, image.height);
  const bool written = guarded(writer.png(), [&] {
    for (std::size_t first = 0; first < image.bytes.size(); first += stride) {
      png_write_row(writer.png(), image.bytes.data() + first);
    }
    png_write_end(writer.png(), nullptr);
  });
  if (!written) fail(image.width, image.height);
  return encoded;
}

void write_png_rows(AtomicFile& file, int width, int height, int channels, const FillRow& fill_row,
                    int compression) {
  if (width <= 0 || height <= 0 || channels < 1 || channels > 4) {
    throw UsageError("an image needs at least one pixel and one to four channels");
  }
  Writer writer;
  std::string encoded;
  const Image head{width, height, channels, 1, 255, {}};
  if (!begin(writer, encoded, head, compression)) fail(width, height);
  std::vector<std::uint8_t> samples(static_cast<std::size_t>(width) *
                                    static_cast<std::size_t>(channels));
  for (int row = 0; row < height; ++row) {
    fill_row(row, samples);
    if (!guarded(writer.png(), [&] { png_write_row(writer.png(), samples.data()); }))
      fail(width, height);
    file.write(encoded);
    encoded.clear();
  }
  if (!guarded(writer.png(), [&] { png_write_end(writer.png(), nullptr); })) fail(width, height);
  file.write(encoded);
}

void write_png_rows(const std::string& path, int width, int height, int channels,
                    const std::function<void(int row, std::span<std::uint8_t> samples)>& fill_row,
                    int compression) {
  AtomicFile file(path);
  write_png_rows(file, width, height, channels, fill_row, compression);
  file.commit();
}

}  // namespace loopstone
