#include <png.h>

#include <bit>
#include <csetjmp>
#include <cstdint>
#include <string>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/image.hpp"

// libpng reports errors by longjmp, which skips destructors. So every call that may jump sits in guarded(), whose body
// holds no object that would need one.

namespace loopstone {
namespace {

constexpr std::size_t kMostPixels = std::size_t{1} << 28;

struct Failure {
  char reason[160] = "";
};

void on_error(png_structp png, png_const_charp message) {
  auto* failure = static_cast<Failure*>(png_get_error_ptr(png));
  std::size_t i = 0;
  for (; message[i] != '\0' && i + 1 < sizeof failure->reason; ++i) failure->reason[i] = message[i];
  failure->reason[i] = '\0';
  png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

/// Runs body; false when libpng jumped out of it.
template <typename Body>
bool guarded(png_structp png, const Body& body) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  body();
  return true;
}

struct Source {
  std::string_view bytes;
  std::size_t position = 0;
};

void read_bytes(png_structp png, png_bytep to, std::size_t count) {
  auto* source = static_cast<Source*>(png_get_io_ptr(png));
  if (source->bytes.size() - source->position < count) png_error(png, "the file ends too early");
  std::memcpy(to, source->bytes.data() + source->position, count);
  source->position += count;
}

class Reader {
 public:
  Reader() : png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, &failure, on_error, on_warning)) {
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
    if (info_ == nullptr) throw std::bad_alloc();
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() { png_destroy_read_struct(&png_, &info_, nullptr); }

  [[nodiscard]] png_structp png() const { return png_; }
  [[nodiscard]] png_infop info() const { return info_; }
  Failure failure{};

 private:
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

class Writer {
 public:
  Writer() : png_(png_create_write_struct(PNG_LIBPNG_VER_STRING, &failure, on_error, on_warning)) {
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
    if (info_ == nullptr) throw std::bad_alloc();
  }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  ~Writer() { png_destroy_write_struct(&png_, &info_); }

  [[nodiscard]] png_structp png() const { return png_; }
  [[nodiscard]] png_infop info() const { return info_; }
  Failure failure{};

 private:
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

void append_bytes(png_structp png, png_bytep from, std::size_t count) {
  static_cast<std::string*>(png_get_io_ptr(png))
      ->append(reinterpret_cast<const char*>(from), count);
}

/// Everything comes out as 1 to 4 channels of 8 or 16 bits in the machine's byte order.
void ask_for_plain_samples(png_structp png) {
  png_set_expand(png);  // palettes, fewer bits than 8, transparent colours as alpha
  if constexpr (std::endian::native == std::endian::little) png_set_swap(png);
  png_set_interlace_handling(png);
}

int colour_type_of(int channels) {
  constexpr int kTypes[] = {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB,
                            PNG_COLOR_TYPE_RGB_ALPHA};
  return kTypes[channels - 1];
}

std::vector<std::uint8_t*> rows_of(Image& image) {
  const std::size_t stride = image.bytes.size() / static_cast<std::size_t>(image.height);
  std::vector<std::uint8_t*> rows(static_cast<std::size_t>(image.height));
  for (std::size_t row = 0; row < rows.size(); ++row) rows[row] = image.bytes.data() + row * stride;
  return rows;
}

}  // namespace

Image decode_png(std::string_view bytes, const std::string& path_for_errors) {
  Reader reader;
  const auto fail = [&](const std::string& reason) {
    throw DataError({path_for_errors}, "is a damaged PNG picture: " + reason);
  };
  Source source{bytes};
  const bool header_read = guarded(reader.png(), [&] {
    png_set_read_fn(reader.png(), &source, read_bytes);
    png_set_user_limits(reader.png(), 1U << 20, 1U << 20);
    png_set_chunk_malloc_max(reader.png(), 1U << 24);
    png_read_info(reader.png(), reader.info());
    ask_for_plain_samples(reader.png());
    png_read_update_info(reader.png(), reader.info());
  });
  if (!header_read) fail(reader.failure.reason);

  const std::size_t width = png_get_image_width(reader.png(), reader.info());
  const std::size_t height = png_get_image_height(reader.png(), reader.info());
  const std::size_t row_bytes = png_get_rowbytes(reader.png(), reader.info());
  if (width * height > kMostPixels) fail("it claims more than 2^28 pixels");
  // Deflate shrinks at most 1032 to 1; a header that claims more lies, and is not worth the memory. Packed pixels
  // (one bit each) expand by up to 8 x 4 more.
  if (row_bytes * height / (1032 * 32) > bytes.size())
    fail("it claims more pixels than its data can hold");

  Image image = make_image(static_cast<int>(width), static_cast<int>(height),
                           png_get_channels(reader.png(), reader.info()),
                           png_get_bit_depth(reader.png(), reader.info()) == 16 ? 2 : 1);
  std::vector<std::uint8_t*> rows = rows_of(image);
  const bool pixels_read = guarded(reader.png(), [&] {
    png_read_image(reader.png(), rows.data());
    png_read_end(reader.png(), nullptr);
  });
  if (!pixels_read) fail(reader.failure.reason);
  return image;
}

std::string encode_png(const Image& image, int compression) {
  Writer writer;
  std::string encoded;
  const std::size_t stride = image.bytes.size() / static_cast<std::size_t>(image.height);
  const bool written = guarded(writer.png(), [&] {
    png_set_write_fn(writer.png(), &encoded, append_bytes, nullptr);
    png_set_compression_level(writer.png(), compression);
    // Maps are flat areas: guessing the best filter for each row costs more time than it saves bytes.
    png_set_filter(writer.png(), 0, compression < 6 ? PNG_FILTER_SUB : PNG_ALL_FILTERS);
    png_set_IHDR(writer.png(), writer.info(), static_cast<png_uint_32>(image.width),
                 static_cast<png_uint_32>(image.height), 8 * image.bytes_per_sample,
                 colour_type_of(image.channels), PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_write_info(writer.png(), writer.info());
    if (image.bytes_per_sample == 2 && std::endian::native == std::endian::little)
      png_set_swap(writer.png());
    for (std::size_t begin = 0; begin < image.bytes.size(); begin += stride) {
      png_write_row(writer.png(), image.bytes.data() + begin);
    }
    png_write_end(writer.png(), nullptr);
  });
  if (!written)
    throw std::runtime_error(std::string("libpng could not encode a picture: ") +
                             writer.failure.reason);
  return encoded;
}

}  // namespace loopstone
