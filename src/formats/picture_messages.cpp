#include "formats/picture_messages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <vector>

#include "formats/mosaic.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/rgbd_files.hpp"
#include "loopstone/sensor/camera_geometry.hpp"

namespace loopstone {
namespace {

using std::string_view;

/// Pixels of interleaved samples. Channels name places of red, green, blue in a pixel.
struct PixelLayout {
  string_view encoding;
  int samples = 3;
  int bytes = 1;  ///< of a sample
  std::array<int, 3> rgb{0, 1, 2};
};
constexpr std::array<PixelLayout, 14> kPixelLayouts{{
    {"rgb8", 3, 1, {0, 1, 2}},
    {"bgr8", 3, 1, {2, 1, 0}},
    {"rgba8", 4, 1, {0, 1, 2}},
    {"bgra8", 4, 1, {2, 1, 0}},
    {"rgb16", 3, 2, {0, 1, 2}},
    {"bgr16", 3, 2, {2, 1, 0}},
    {"rgba16", 4, 2, {0, 1, 2}},
    {"bgra16", 4, 2, {2, 1, 0}},
    {"mono8", 1, 1, {0, 0, 0}},
    {"8UC1", 1, 1, {0, 0, 0}},
    // What OpenCV's numbers of channels mean is not said; it orders blue, green, red.
    {"8UC3", 3, 1, {2, 1, 0}},
    {"8UC4", 4, 1, {2, 1, 0}},
    {"mono16", 1, 2, {0, 0, 0}},
    {"16UC1", 1, 2, {0, 0, 0}},
}};

const PixelLayout* layout_of(string_view encoding) {
  const auto* const found =
      std::ranges::find(kPixelLayouts, encoding, [](const PixelLayout& l) { return l.encoding; });
  return found == kPixelLayouts.end() ? nullptr : found;
}

/// Two pixels in four bytes, which share their colour: where brightness and colour stand.
struct PairLayout {
  string_view encoding;
  int y0, u, y1, v;
};
constexpr std::array<PairLayout, 4> kPairLayouts{{
    {"yuv422", 1, 0, 3, 2},
    {"uyvy", 1, 0, 3, 2},
    {"yuv422_yuy2", 0, 1, 2, 3},
    {"yuyv", 0, 1, 2, 3},
}};

const PairLayout* pair_layout_of(string_view encoding) {
  const auto* const found =
      std::ranges::find(kPairLayouts, encoding, [](const PairLayout& l) { return l.encoding; });
  return found == kPairLayouts.end() ? nullptr : found;
}

/// The rows of a message's pixels, after a check that they are all there.
class PixelRows {
 public:
  PixelRows(const msg::Image& message, std::uint64_t pixel_bytes, const std::string& where)
      : message_(message) {
    constexpr std::uint32_t kMostSide = 1U << 16U;
    const std::uint64_t row = message.width * pixel_bytes;
    if (message.width == 0 || message.height == 0 || message.width > kMostSide ||
        message.height > kMostSide) {
      throw DataError({where}, fmt::format("a picture of {} x {} pixels can't be used",
                                           message.width, message.height));
    }
    if (message.step < row) {
      throw DataError({where}, fmt::format("its rows of {} bytes can't hold {} pixels of {}",
                                           message.step, message.width, message.encoding));
    }
    const std::uint64_t needed =
        std::uint64_t{message.step} * (std::uint64_t{message.height} - 1) + row;
    if (message.data.size() < needed) {
      throw DataError(
          {where}, fmt::format("has {} bytes of pixels, {} x {} of {} need {}", message.data.size(),
                               message.width, message.height, message.encoding, needed));
    }
  }

  [[nodiscard]] int width() const { return static_cast<int>(message_.width); }
  [[nodiscard]] int height() const { return static_cast<int>(message_.height); }
  [[nodiscard]] const std::uint8_t* row(int row) const {
    return message_.data.data() + static_cast<std::size_t>(row) * message_.step;
  }

 private:
  const msg::Image& message_;
};

ColourImage empty_colour(const PixelRows& rows) {
  ColourImage colour{rows.width(), rows.height(), {}};
  colour.rgb.reserve(3 * static_cast<std::size_t>(rows.width()) *
                     static_cast<std::size_t>(rows.height()));
  return colour;
}

ColourImage colour_of_pixels(const msg::Image& message, const PixelLayout& layout,
                             const std::string& where) {
  const int pixel_bytes = layout.samples * layout.bytes;
  const PixelRows rows(message, static_cast<std::uint64_t>(pixel_bytes), where);
  ColourImage colour = empty_colour(rows);
  // Of a sample of 16 bits the upper half is kept.
  const int upper = layout.bytes == 2 && message.is_bigendian == 0 ? 1 : 0;
  for (int row = 0; row < rows.height(); ++row) {
    const std::uint8_t* pixel = rows.row(row);
    for (int column = 0; column < rows.width(); ++column, pixel += pixel_bytes) {
      for (const int channel : layout.rgb) {
        colour.rgb.push_back(pixel[channel * layout.bytes + upper]);
      }
    }
  }
  return colour;
}

/// Source: ITU-R BT.601-7, section 2.5.3, with the full range of numbers that cameras use.
void push_rgb_of_yuv(double y, double u, double v, std::vector<std::uint8_t>& rgb) {
  const auto push = [&](double value) {
    rgb.push_back(static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0)));
  };
  push(y + 1.402 * v);
  push(y - 0.344136 * u - 0.714136 * v);
  push(y + 1.772 * u);
}

ColourImage colour_of_pairs(const msg::Image& message, const PairLayout& layout,
                            const std::string& where) {
  if (message.width % 2 != 0) throw DataError({where}, "has an odd number of pixels a row");
  const PixelRows rows(message, 2, where);
  ColourImage colour = empty_colour(rows);
  for (int row = 0; row < rows.height(); ++row) {
    const std::uint8_t* pair = rows.row(row);
    for (int column = 0; column < rows.width(); column += 2, pair += 4) {
      const double u = pair[layout.u] - 128.0;
      const double v = pair[layout.v] - 128.0;
      push_rgb_of_yuv(pair[layout.y0], u, v, colour.rgb);
      push_rgb_of_yuv(pair[layout.y1], u, v, colour.rgb);
    }
  }
  return colour;
}

ColourImage colour_of_mosaic(const msg::Image& message, const std::string& where) {
  const auto order = mosaic_order(message.encoding);
  const PixelRows rows(message, 1, where);
  return fill_mosaic([&](int row) { return rows.row(row); }, rows.width(), rows.height(), *order);
}

/// An encoding whose numbers are depths.
DepthEncoding as_depth(const DepthEncoding& encoding) {
  DepthEncoding depth = encoding;
  if (depth.kind == DepthKind::kDepth) return depth;
  depth.kind = DepthKind::kDepth;
  depth.metres_per_unit = 0.001;
  return depth;
}

InverseDepthImage empty_depth(const PixelRows& rows) {
  return {rows.width(), rows.height(),
          std::vector<float>(static_cast<std::size_t>(rows.width()) *
                             static_cast<std::size_t>(rows.height()))};
}

/// Calls of(the bytes of a pixel), whose low one comes first, for each.
template <std::size_t kBytes, typename Of>
InverseDepthImage depth_of_pixels(const msg::Image& message, const std::string& where,
                                  const Of& of) {
  const PixelRows rows(message, kBytes, where);
  InverseDepthImage depth = empty_depth(rows);
  float* to = depth.per_m.data();
  for (int row = 0; row < rows.height(); ++row) {
    const std::uint8_t* from = rows.row(row);
    for (int column = 0; column < rows.width(); ++column, from += kBytes) {
      std::array<std::uint8_t, kBytes> pixel{};
      std::copy_n(from, kBytes, pixel.begin());
      if (message.is_bigendian != 0) std::ranges::reverse(pixel);
      *to++ = of(pixel);
    }
  }
  return depth;
}

/// NaN is no measurement, and 0 not either.
float inverse_within(float depth_m, const DepthEncoding& encoding) {
  const bool is_seen = depth_m > 0.0F && depth_m >= static_cast<float>(encoding.range_min_m) &&
                       depth_m <= static_cast<float>(encoding.range_max_m);
  return is_seen ? 1.0F / depth_m : 0.0F;
}

string_view chars_of(const std::vector<std::uint8_t>& data) {
  return {reinterpret_cast<const char*>(data.data()), data.size()};
}

/// What image_transport's compressedDepth puts before the picture.
struct CompressedDepthHead {
  static constexpr std::size_t kBytes = 12;
  float numerator = 0.0F;  ///< of 32FC1: depth = numerator / (number - offset)
  float offset = 0.0F;
};

CompressedDepthHead read_compressed_head(string_view data) {
  static_assert(std::endian::native == std::endian::little);
  CompressedDepthHead head;
  std::memcpy(&head.numerator, data.data() + 4, 4);
  std::memcpy(&head.offset, data.data() + 8, 4);
  return head;
}

/// Inverse depth as 16-bit numbers. Source: compressed_depth_image_transport of ROS's
/// image_transport_plugins.
InverseDepthImage depth_of_quantised(string_view png, const CompressedDepthHead& head,
                                     const DepthEncoding& encoding, const std::string& where) {
  const Image image = decode_png(png, where);
  if (image.channels != 1 || image.bytes_per_sample != 2) {
    throw DataError({where}, "a compressed depth picture needs one channel of 16 bits");
  }
  InverseDepthImage depth{image.width, image.height, std::vector<float>(image.sample_count())};
  for (std::size_t i = 0; i < depth.per_m.size(); ++i) {
    std::uint16_t number = 0;
    std::memcpy(&number, image.bytes.data() + 2 * i, sizeof number);
    if (number == 0) continue;
    const float depth_m = head.numerator / (static_cast<float>(number) - head.offset);
    depth.per_m[i] = inverse_within(depth_m, encoding);
  }
  return depth;
}

}  // namespace

PictureContent content_of(string_view encoding) {
  if (encoding == "16UC1" || encoding == "32FC1") return PictureContent::kDepth;
  if (encoding == "mono16") return PictureContent::kGrey16;
  if (layout_of(encoding) != nullptr || pair_layout_of(encoding) != nullptr ||
      mosaic_order(encoding)) {
    return PictureContent::kColour;
  }
  const auto says = [&](string_view word) { return encoding.find(word) != string_view::npos; };
  if (says("rvl")) return PictureContent::kUnknown;
  if (says("compressedDepth") || says("16UC1") || says("32FC1")) return PictureContent::kDepth;
  if (says("mono16") && says("png")) return PictureContent::kGrey16;
  if (says("jpeg") || says("jpg") || says("png")) return PictureContent::kColour;
  return PictureContent::kUnknown;
}

ColourImage to_colour(const msg::Image& message, const std::string& where) {
  if (const auto* layout = layout_of(message.encoding)) {
    return colour_of_pixels(message, *layout, where);
  }
  if (const auto* layout = pair_layout_of(message.encoding)) {
    return colour_of_pairs(message, *layout, where);
  }
  if (mosaic_order(message.encoding)) return colour_of_mosaic(message, where);
  throw DataError({where}, "a picture in the encoding '" + message.encoding.substr(0, 40) +
                               "' can't be used for its colour");
}

ColourImage to_colour(const msg::CompressedImage& message, const std::string& where) {
  return decode_colour(chars_of(message.data), where);
}

InverseDepthImage to_depth(const msg::Image& message, const DepthEncoding& encoding,
                           const std::string& where) {
  if (message.encoding == "32FC1") {
    return depth_of_pixels<4>(message, where, [&](const std::array<std::uint8_t, 4>& pixel) {
      return inverse_within(std::bit_cast<float>(pixel), encoding);
    });
  }
  if (message.encoding != "16UC1" && message.encoding != "mono16") {
    throw DataError({where}, "a picture in the encoding '" + message.encoding.substr(0, 40) +
                                 "' can't be used for its depth");
  }
  const std::vector<float> per_m_of_number = inverse_depth_table(as_depth(encoding));
  return depth_of_pixels<2>(message, where, [&](const std::array<std::uint8_t, 2>& pixel) {
    return per_m_of_number[std::bit_cast<std::uint16_t>(pixel)];
  });
}

InverseDepthImage to_depth(const msg::CompressedImage& message, const DepthEncoding& encoding,
                           const std::string& where) {
  string_view data = chars_of(message.data);
  const DepthEncoding depths = as_depth(encoding);
  if (message.format.find("compressedDepth") != std::string::npos) {
    if (data.size() < CompressedDepthHead::kBytes) throw DataError({where}, "is cut off");
    const CompressedDepthHead head = read_compressed_head(data);
    data.remove_prefix(CompressedDepthHead::kBytes);
    if (message.format.find("32FC1") != std::string::npos) {
      return depth_of_quantised(data, head, depths, where);
    }
  }
  return decode_depth(data, depths, inverse_depth_table(depths), where);
}

}  // namespace loopstone
