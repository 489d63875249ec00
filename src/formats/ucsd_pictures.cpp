#include "loopstone/formats/ucsd_pictures.hpp"

#include <cstddef>
#include <cstring>
#include <filesystem>
#include <initializer_list>
#include <system_error>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/image.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

constexpr int kCompression = 1;  // noise does not get smaller by trying harder

fs::path folder_of(const UcsdPictures& pictures, const char* kind) {
  return fs::path(pictures.folder) / "dataRGBD" / (kind + std::to_string(pictures.set));
}

std::string path_of(const UcsdPictures& pictures, const char* kind, const char* prefix,
                    std::int64_t index) {
  const std::string name =
      prefix + std::to_string(pictures.set) + "_" + std::to_string(index + 1) + ".png";
  return (folder_of(pictures, kind) / name).string();
}

}  // namespace

std::string UcsdPictures::colour_path(std::int64_t index) const {
  return path_of(*this, "RGB", "rgb", index);
}

std::string UcsdPictures::depth_path(std::int64_t index) const {
  return holds_disparity ? path_of(*this, "Disparity", "disparity", index)
                         : path_of(*this, "Depth", "depth", index);
}

void UcsdPictures::make_folders() const {
  for (const char* kind : {"RGB", holds_disparity ? "Disparity" : "Depth"}) {
    const fs::path made = folder_of(*this, kind);
    std::error_code error;
    fs::create_directories(made, error);
    if (error || !fs::is_directory(made)) {
      throw DataError({made.string()}, "the folder can't be made: " + error.message());
    }
  }
}

void UcsdPictures::write_colour(std::int64_t index, const ColourImage& colour) const {
  Image image = make_image(colour.width, colour.height, 3);
  image.bytes = colour.rgb;
  write_png(colour_path(index), image, kCompression);
}

void UcsdPictures::write_depth(std::int64_t index, const RawDepthImage& depth) const {
  Image image = make_image(depth.width, depth.height, 1, 2);
  std::memcpy(image.bytes.data(), depth.numbers.data(), image.bytes.size());
  write_png(depth_path(index), image, kCompression);
}

}  // namespace loopstone
