#include <png.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "formats/picture_size.hpp"
#include "formats/png_guard.hpp"
#include "formats/png_plain.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/image.hpp"

namespace loopstone {
namespace {

struct Source {
  std::string_view bytes;
  std::size_t position = 0;
  bool is_cut_off = false;
};

void read_bytes(png_structp png, png_bytep to, std::size_t count) {
  auto* source = static_cast<Source*>(png_get_io_ptr(png));
  if (source->bytes.size() - source->position < count) {
    source->is_cut_off = true;
    png_error(png, "cut off");
  }
  std::memcpy(to, source->bytes.data() + source->position, count);
  source->position += count;
}

class Reader {
 public:
  Reader()
      : png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, on_png_error, on_png_warning)) {
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
    if (info_ == nullptr) throw std::bad_alloc();
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() { png_destroy_read_struct(&png_, &info_, nullptr); }

  [[nodiscard]] png_structp png() const { return png_; }
  [[nodiscard]] png_infop info() const { return info_; }

 private:
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

/// Everything comes out as 1 to 4 channels of 8 or 16 bits in the machine's byte order.
void ask_for_plain_samples(png_structp png) {
  png_set_expand(png);  // palettes, fewer bits than 8, transparent colours as alpha
  if constexpr (std::endian::native == std::endian::little) png_set_swap(png);
  png_set_interlace_handling(png);
}

std::vector<std::uint8_t*> rows_of(Image& image) {
  const std::size_t stride = image.bytes.size() / static_cast<std::size_t>(image.height);
  std::vector<std::uint8_t*> rows(static_cast<std::size_t>(image.height));
  for (std::size_t row = 0; row < rows.size(); ++row) rows[row] = image.bytes.data() + row * stride;
  return rows;
}

}  // namespace

Image decode_png(std::string_view bytes, const std::string& path_for_errors,
                 const MemoryBudget& budget) {
  if (auto plain = decode_plain_png(bytes, path_for_errors, budget)) return std::move(*plain);
  return decode_any_png(bytes, path_for_errors, budget);
}

Image decode_any_png(std::string_view bytes, const std::string& path_for_errors,
                     const MemoryBudget& budget) {
  Reader reader;
  Source source{bytes};
  const auto fail = [&](const std::string& reason) {
    throw DataError({path_for_errors, {}, static_cast<std::int64_t>(source.position)},
                    "is a damaged PNG picture: " +
                        (source.is_cut_off ? std::string("the file ends too early") : reason));
  };
  const bool header_read = guarded(reader.png(), [&] {
    png_set_read_fn(reader.png(), &source, read_bytes);
    png_set_user_limits(reader.png(), kMostPictureSide, kMostPictureSide);
    png_set_chunk_malloc_max(reader.png(), 1U << 24);
    png_read_info(reader.png(), reader.info());
    ask_for_plain_samples(reader.png());
    png_read_update_info(reader.png(), reader.info());
  });
  if (!header_read) fail("its head makes no sense");

  const std::size_t width = png_get_image_width(reader.png(), reader.info());
  const std::size_t height = png_get_image_height(reader.png(), reader.info());
  const std::size_t row_bytes = png_get_rowbytes(reader.png(), reader.info());
  // Deflate shrinks at most 1032 to 1; a header that claims more lies, and is not worth the memory.
  // Packed pixels (one bit each) expand by up to 8 x 4 more.
  if (row_bytes * height / (1032 * 32) > bytes.size())
    fail("it claims more pixels than its data can hold");
  require_picture(width, height, row_bytes / width, bytes.size(), budget, {path_for_errors});

  Image image = make_image(static_cast<int>(width), static_cast<int>(height),
                           png_get_channels(reader.png(), reader.info()),
                           png_get_bit_depth(reader.png(), reader.info()) == 16 ? 2 : 1);
  std::vector<std::uint8_t*> rows = rows_of(image);
  const bool pixels_read = guarded(reader.png(), [&] {
    png_read_image(reader.png(), rows.data());
    png_read_end(reader.png(), nullptr);
  });
  if (!pixels_read) fail("its pixels don't unpack, or a checksum is wrong");
  return image;
}

}  // namespace loopstone
