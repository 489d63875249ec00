#include <csetjmp>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <new>
#include <string>
// clang-format off: jpeglib.h needs what stands above, and does not include it
#include <jerror.h>
#include <jpeglib.h>
// clang-format on

#include "formats/picture_size.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/image.hpp"

namespace loopstone {
namespace {

/// libjpeg reports errors by a function that must not return.
struct JpegErrors {
  jpeg_error_mgr manager{};
  std::jmp_buf jump{};
};

[[noreturn]] void on_jpeg_error(j_common_ptr jpeg) {
  std::longjmp(reinterpret_cast<JpegErrors*>(jpeg->err)->jump, 1);
}

/// Pixels that were made up are counted (num_warnings); bytes too many, as cameras leave them, do
/// no harm. What libjpeg says of either does not reach people.
void on_jpeg_warning(j_common_ptr jpeg, int level) {
  if (level >= 0) return;
  const int code = jpeg->err->msg_code;
  if (code == JWRN_EXTRANEOUS_DATA || code == JWRN_JFIF_MAJOR || code == JWRN_ADOBE_XFORM) return;
  ++jpeg->err->num_warnings;
}

/// Each pass over a progressive picture costs as much as all of it, and a few bytes ask for one.
void stop_endless_passes(j_common_ptr jpeg) {
  constexpr int kMostPasses = 100;
  if (reinterpret_cast<j_decompress_ptr>(jpeg)->input_scan_number > kMostPasses) {
    on_jpeg_error(jpeg);
  }
}

class JpegReader {
 public:
  explicit JpegReader(std::string_view bytes) {
    jpeg_.err = jpeg_std_error(&errors_.manager);
    errors_.manager.error_exit = on_jpeg_error;
    errors_.manager.emit_message = on_jpeg_warning;
    progress_.progress_monitor = stop_endless_passes;
    if (setjmp(errors_.jump) != 0) {
      jpeg_destroy_decompress(&jpeg_);
      throw std::bad_alloc();
    }
    jpeg_create_decompress(&jpeg_);
    jpeg_.progress = &progress_;
    jpeg_mem_src(&jpeg_, reinterpret_cast<const unsigned char*>(bytes.data()),
                 static_cast<unsigned long>(bytes.size()));
  }
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;
  ~JpegReader() { jpeg_destroy_decompress(&jpeg_); }

  /// False: this is no JPEG that can be read.
  [[nodiscard]] bool read_head() {
    if (setjmp(errors_.jump) != 0) return false;
    jpeg_read_header(&jpeg_, TRUE);
    jpeg_.out_color_space = jpeg_.num_components == 1 ? JCS_GRAYSCALE : JCS_RGB;
    jpeg_calc_output_dimensions(&jpeg_);
    return true;
  }
  /// \param image  of the size that the head says
  [[nodiscard]] bool read_rows(Image& image) {
    unsigned char* row = image.bytes.data();
    const std::size_t stride = image.bytes.size() / static_cast<std::size_t>(image.height);
    if (setjmp(errors_.jump) != 0) return false;
    jpeg_start_decompress(&jpeg_);
    while (jpeg_.output_scanline < jpeg_.output_height) {
      unsigned char* const to = row + jpeg_.output_scanline * stride;
      JSAMPROW rows[1] = {to};
      jpeg_read_scanlines(&jpeg_, static_cast<JSAMPARRAY>(rows), 1);
    }
    jpeg_finish_decompress(&jpeg_);
    return errors_.manager.num_warnings == 0;
  }

  [[nodiscard]] std::uint64_t width() const { return jpeg_.output_width; }
  [[nodiscard]] std::uint64_t height() const { return jpeg_.output_height; }
  [[nodiscard]] int channels() const { return jpeg_.out_color_space == JCS_GRAYSCALE ? 1 : 3; }
  /// libjpeg holds all coefficients of those: two bytes a sample.
  [[nodiscard]] bool is_progressive() { return jpeg_has_multiple_scans(&jpeg_) != 0; }

 private:
  JpegErrors errors_{};
  jpeg_progress_mgr progress_{};
  jpeg_decompress_struct jpeg_{};
};

}  // namespace

Image decode_jpeg(std::string_view bytes, const std::string& path_for_errors,
                  const MemoryBudget& budget) {
  JpegReader reader(bytes);
  if (!reader.read_head()) {
    throw DataError({path_for_errors}, "is a damaged JPEG picture: its head makes no sense");
  }
  const auto channels = static_cast<std::uint64_t>(reader.channels());
  const std::uint64_t pixel_bytes = reader.is_progressive() ? 3 * channels : channels;
  require_picture(reader.width(), reader.height(), pixel_bytes, bytes.size(), budget,
                  {path_for_errors});
  Image image = make_image(static_cast<int>(reader.width()), static_cast<int>(reader.height()),
                           reader.channels());
  if (!reader.read_rows(image)) {
    throw DataError({path_for_errors}, "is a damaged JPEG picture: its pixels don't unpack");
  }
  return image;
}

}  // namespace loopstone
