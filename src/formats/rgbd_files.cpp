#include "loopstone/formats/rgbd_files.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <mutex>
#include <utility>
#include <variant>

#include "formats/atomic_file.hpp"
#include "formats/float_image.hpp"
#include "formats/png_plain.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/sensor/camera_geometry.hpp"

namespace loopstone {
namespace {

constexpr std::size_t kMostPictureBytes = std::size_t{1} << 30;

std::string size_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height) + " pixels";
}

void check_size(int width, int height, const LensModel& lens, const std::string& table,
                const std::string& path) {
  if (width == lens.width_px && height == lens.height_px) return;
  throw DataError({path}, "is " + size_text(width, height) + ", but the robot file's [" + table +
                              "] says " + size_text(lens.width_px, lens.height_px) +
                              "; give the robot file of this camera (--robot), or correct its "
                              "width_px and height_px, and its focal lengths and centre with them");
}

void check_colour_size(const ColourImage& colour, const CameraModel& camera,
                       const std::string& path) {
  check_size(colour.width, colour.height, colour_lens(camera),
             camera.colour_is_registered ? "camera.depth" : "camera.colour", path);
}

void check_depth_size(const InverseDepthImage& depth, const CameraModel& camera,
                      const std::string& path) {
  check_size(depth.width, depth.height, camera.depth, "camera.depth", path);
}

/// Any sample as 8 bits, rounded.
class ToEightBits {
 public:
  explicit ToEightBits(const Image& image) : image_(image) {}

  [[nodiscard]] std::uint8_t operator()(std::size_t sample) const {
    const unsigned most = static_cast<unsigned>(image_.max_value);
    unsigned value = image_.bytes[sample];
    if (image_.bytes_per_sample == 2) {
      std::uint16_t wide = 0;
      std::memcpy(&wide, image_.bytes.data() + 2 * sample, sizeof wide);
      value = wide;
    }
    return static_cast<std::uint8_t>(most == 255 ? value : (value * 255U + most / 2U) / most);
  }

 private:
  const Image& image_;
};

ColourImage to_colour(Image image) {
  ColourImage colour{image.width, image.height, {}};
  if (image.channels == 3 && image.max_value == 255) {
    colour.rgb = std::move(image.bytes);
    return colour;
  }
  const auto channels = static_cast<std::size_t>(image.channels);
  const std::size_t pixels = image.sample_count() / channels;
  const std::size_t step = channels < 3 ? 0 : 1;  // grey stands for all three
  const ToEightBits eight_bits(image);
  colour.rgb.reserve(3 * pixels);
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      colour.rgb.push_back(eight_bits(pixel * channels + channel * step));
    }
  }
  return colour;
}

ColourImage colour_of_rows(const PngRows& rows) {
  ColourImage colour{rows.width, rows.height, {}};
  colour.rgb.reserve(rows.row_bytes() * static_cast<std::size_t>(rows.height));
  for (int row = 0; row < rows.height; ++row) {
    colour.rgb.insert(colour.rgb.end(), rows.row(row), rows.row(row) + rows.row_bytes());
  }
  return colour;
}

InverseDepthImage explain_rows(const PngRows& rows, std::span<const float> per_m_of_number) {
  const auto width = static_cast<std::size_t>(rows.width);
  InverseDepthImage depth{rows.width, rows.height,
                          std::vector<float>(width * static_cast<std::size_t>(rows.height))};
  float* to = depth.per_m.data();
  for (int row = 0; row < rows.height; ++row, to += width) {
    const std::uint8_t* const from = rows.row(row);
    for (std::size_t i = 0; i < width; ++i) {
      to[i] = per_m_of_number[from[2 * i] * std::size_t{256} + from[2 * i + 1]];
    }
  }
  return depth;
}

InverseDepthImage explain_numbers(const Image& image, std::span<const float> per_m_of_number,
                                  const std::string& path) {
  if (image.channels != 1 || image.bytes_per_sample != 2) {
    throw DataError({path}, "has " + std::to_string(image.channels) + " channels of " +
                                std::to_string(8 * image.bytes_per_sample) +
                                " bits; a depth picture has one of 16 bits, or holds metres as "
                                "32-bit numbers (.pfm, .tiff)");
  }
  InverseDepthImage depth{image.width, image.height, std::vector<float>(image.sample_count())};
  for (std::size_t i = 0; i < depth.per_m.size(); ++i) {
    std::uint16_t number = 0;
    std::memcpy(&number, image.bytes.data() + 2 * i, sizeof number);
    depth.per_m[i] = per_m_of_number[number];
  }
  return depth;
}

InverseDepthImage invert_metres(const FloatImage& image, const DepthEncoding& encoding) {
  InverseDepthImage depth{image.width, image.height, std::vector<float>(image.values.size())};
  const auto nearest_m = static_cast<float>(encoding.range_min_m);
  const auto farthest_m = static_cast<float>(encoding.range_max_m);
  for (std::size_t i = 0; i < depth.per_m.size(); ++i) {
    const float depth_m = image.values[i];
    // Written so that NaN is no measurement, and 0 not either whatever the range.
    const bool is_seen = depth_m > 0.0F && depth_m >= nearest_m && depth_m <= farthest_m;
    depth.per_m[i] = is_seen ? 1.0F / depth_m : 0.0F;
  }
  return depth;
}

ColourImage decode_colour(std::string_view bytes, PngScratch& scratch, const std::string& path) {
  if (is_tiff(bytes)) {
    throw DataError({path}, "is TIFF; colour pictures are PNG or PNM: convert it");
  }
  const auto rows = unpack_plain_png(bytes, scratch);
  if (rows && rows->channels == 3 && rows->bytes_per_sample == 1) return colour_of_rows(*rows);
  return to_colour(decode_image(bytes, path));
}

InverseDepthImage decode_depth(std::string_view bytes, const DepthEncoding& encoding,
                               std::span<const float> per_m_of_number, PngScratch& scratch,
                               const std::string& path) {
  const auto rows = unpack_plain_png(bytes, scratch);
  if (rows && rows->channels == 1 && rows->bytes_per_sample == 2) {
    return explain_rows(*rows, per_m_of_number);
  }
  if (bytes.starts_with("Pf") || bytes.starts_with("PF")) {
    return invert_metres(decode_pfm(bytes, path), encoding);
  }
  if (is_tiff(bytes)) {
    const auto picture = decode_tiff(bytes, path);
    if (const auto* metres = std::get_if<FloatImage>(&picture)) {
      return invert_metres(*metres, encoding);
    }
    return explain_numbers(std::get<Image>(picture), per_m_of_number, path);
  }
  return explain_numbers(decode_image(bytes, path), per_m_of_number, path);
}

/// What one thread needs while it loads a picture.
struct Workplace {
  std::string file{};
  PngScratch png{};
};

}  // namespace

/// The workplaces that are free.
struct RgbdLoader::Workplaces {
  std::mutex mutex{};
  std::vector<std::unique_ptr<Workplace>> free{};

  /// Runs body(workplace) with one that no other thread has.
  template <typename Body>
  auto with_one(const Body& body) {
    std::unique_ptr<Workplace> mine = take();
    auto result = body(*mine);  // when this throws, the workplace is not missed
    const std::lock_guard lock(mutex);
    free.push_back(std::move(mine));
    return result;
  }

 private:
  std::unique_ptr<Workplace> take() {
    const std::lock_guard lock(mutex);
    if (free.empty()) return std::make_unique<Workplace>();
    std::unique_ptr<Workplace> mine = std::move(free.back());
    free.pop_back();
    return mine;
  }
};

ColourImage decode_colour(std::string_view bytes, const std::string& path_for_errors) {
  PngScratch scratch;
  return decode_colour(bytes, scratch, path_for_errors);
}

InverseDepthImage decode_depth(std::string_view bytes, const DepthEncoding& encoding,
                               std::span<const float> per_m_of_number,
                               const std::string& path_for_errors) {
  PngScratch scratch;
  return decode_depth(bytes, encoding, per_m_of_number, scratch, path_for_errors);
}

RgbdLoader::RgbdLoader(const CameraModel& camera, std::shared_ptr<const PictureStore> pictures)
    : camera_(camera),
      pictures_(std::move(pictures)),
      per_m_of_number_(inverse_depth_table(camera.encoding)),
      workplaces_(std::make_shared<Workplaces>()) {}

ColourImage RgbdLoader::load_colour(const std::string& path) const {
  ColourImage colour = workplaces_->with_one([&](Workplace& mine) {
    mine.file = read_whole_file(path, kMostPictureBytes, std::move(mine.file));
    return decode_colour(mine.file, mine.png, path);
  });
  check_colour_size(colour, camera_, path);
  return colour;
}

InverseDepthImage RgbdLoader::load_depth(const std::string& path) const {
  InverseDepthImage depth = workplaces_->with_one([&](Workplace& mine) {
    mine.file = read_whole_file(path, kMostPictureBytes, std::move(mine.file));
    return decode_depth(mine.file, camera_.encoding, per_m_of_number_, mine.png, path);
  });
  check_depth_size(depth, camera_, path);
  return depth;
}

RgbdImages RgbdLoader::load(const RgbdFrame& frame) const {
  RgbdImages images{frame.stamp, frame.colour_stamp, {}, {}};
  if (!frame.depth_path.empty()) {
    if (frame.depth_message < 0) {
      images.depth = load_depth(frame.depth_path);
    } else if (pictures_) {
      images.depth = pictures_->depth(frame.depth_message, camera_.encoding);
      check_depth_size(images.depth, camera_, frame.depth_path);
    }
  }
  if (!frame.colour_path.empty()) {
    if (frame.colour_message < 0) {
      images.colour = load_colour(frame.colour_path);
    } else if (pictures_) {
      images.colour = pictures_->colour(frame.colour_message);
      check_colour_size(images.colour, camera_, frame.colour_path);
    }
  }
  return images;
}

}  // namespace loopstone
