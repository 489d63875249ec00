#include "loopstone/formats/image.hpp"

#include "formats/atomic_file.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {

Image make_image(int width, int height, int channels, int bytes_per_sample) {
  constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 33;
  if (width <= 0 || height <= 0 || channels < 1 || channels > 4) {
    throw UsageError("an image needs at least one pixel and one to four channels");
  }
  Image image{width, height, channels, bytes_per_sample, bytes_per_sample == 1 ? 255 : 65535};
  const std::uint64_t pixel_bytes =
      static_cast<std::uint64_t>(channels) * static_cast<std::uint64_t>(bytes_per_sample);
  const std::uint64_t bytes = saturated_product(
      saturated_product(static_cast<std::uint64_t>(width), static_cast<std::uint64_t>(height)),
      pixel_bytes);
  if (bytes > kMostBytes) throw UsageError("the image is too large for memory");
  image.bytes.resize(static_cast<std::size_t>(bytes));
  return image;
}

Image decode_image(std::string_view bytes, const std::string& path_for_errors,
                   const MemoryBudget& budget) {
  if (bytes.starts_with("\x89PNG")) return decode_png(bytes, path_for_errors, budget);
  if (bytes.starts_with("\xff\xd8")) return decode_jpeg(bytes, path_for_errors, budget);
  if (bytes.size() >= 2 && bytes[0] == 'P' && bytes[1] >= '1' && bytes[1] <= '7') {
    return decode_pnm(bytes, path_for_errors, budget);
  }
  if (bytes.empty())
    throw DataError({path_for_errors}, "is empty; expected a PGM, PNG or JPEG picture");
  throw DataError({path_for_errors},
                  "is no picture in a known format; convert it to PGM (P2, P5), PNG or JPEG");
}

Image read_image(const std::string& path, const MemoryBudget& budget) {
  return decode_image(read_whole_file(path, budget.ceiling_bytes), path, budget);
}

void write_png(const std::string& path, const Image& image, int compression) {
  write_file_atomically(path, encode_png(image, compression));
}

}  // namespace loopstone
