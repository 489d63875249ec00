#include <algorithm>
#include <array>
#include <string>

#include "formats/camera_lens.hpp"
#include "formats/picture_messages.hpp"
#include "loopstone/base/error.hpp"
#include "refusal.hpp"

// The first byte picks the encoding, the next five width, height, bytes a row beyond them and the
// byte order; the pixels follow. All bytes are also tried as a packed picture, and as the numbers
// of a CameraInfo.
namespace {

using namespace loopstone;

constexpr std::array kEncodings{"rgb8",        "bgra8",       "rgb16",  "mono8",
                                "mono16",      "16UC1",       "32FC1",  "bayer_rggb8",
                                "bayer_gbrg8", "yuv422_yuy2", "yuv422", "jolly8"};
constexpr std::array kFormats{"jpeg", "png", "16UC1; compressedDepth png",
                              "32FC1; compressedDepth png"};

std::uint8_t byte_at(std::string_view text, std::size_t i) {
  return i < text.size() ? static_cast<std::uint8_t>(text[i]) : std::uint8_t{0};
}

msg::Image picture_of(std::string_view text) {
  msg::Image image{.height = byte_at(text, 2),
                   .width = byte_at(text, 1),
                   .encoding = kEncodings[byte_at(text, 0) % kEncodings.size()],
                   .is_bigendian = static_cast<std::uint8_t>(byte_at(text, 5) & 1U)};
  image.step = image.width * byte_at(text, 3) + byte_at(text, 4);
  text.remove_prefix(std::min<std::size_t>(6, text.size()));
  image.data.assign(text.begin(), text.end());
  return image;
}

msg::CameraInfo info_of(std::string_view text) {
  constexpr std::array kModels{"plumb_bob", "rational_polynomial", "equidistant"};
  msg::CameraInfo info{
      .height = 480, .width = 640, .distortion_model = kModels[byte_at(text, 0) % kModels.size()]};
  const auto number = [&](std::size_t i) { return (byte_at(text, i) - 128.0) / 16.0; };
  for (std::size_t i = 0; i < byte_at(text, 1) % 12U; ++i) info.d.push_back(number(i + 2));
  info.k = {100.0 * number(3), 0, 320, 0, 500, 240, 0, 0, 1};
  info.binning_x = byte_at(text, 4) % 4U;
  info.roi.width = byte_at(text, 5);
  info.roi.height = byte_at(text, 6);
  return info;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text = fuzz::text_of(data, size);
  const msg::Image image = picture_of(text);
  const DepthEncoding encoding;
  fuzz::expect_work_or_refusal(text, [&] { (void)to_colour(image, "fuzz"); });
  fuzz::expect_work_or_refusal(text, [&] { (void)to_depth(image, encoding, "fuzz"); });
  for (const char* const format : kFormats) {
    msg::CompressedImage packed{.format = format};
    packed.data.assign(text.begin(), text.end());
    fuzz::expect_work_or_refusal(text, [&] { (void)to_colour(packed, "fuzz"); });
    fuzz::expect_work_or_refusal(text, [&] { (void)to_depth(packed, encoding, "fuzz"); });
  }
  (void)lens_of(info_of(text), byte_at(text, 7) % 2 == 0);
  return 0;
}
