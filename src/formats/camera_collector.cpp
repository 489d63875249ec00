#include "formats/camera_collector.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <variant>

#include "formats/atomic_file.hpp"
#include "formats/float_image.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/median.hpp"
#include "loopstone/formats/image.hpp"

namespace loopstone {
namespace {

template <typename Load>
PictureSize size_of(const std::string& path, const PictureStore* pictures, std::int64_t message,
                    const Load& load) {
  PictureSize size;
  if (path.empty()) return size;
  try {
    const auto take = [&](const auto& image) {
      size.width_px = image.width;
      size.height_px = image.height;
    };
    if (message >= 0) {
      if (pictures != nullptr) take(load(*pictures));
      return size;
    }
    constexpr std::size_t kMostBytes = std::size_t{1} << 30;
    const std::string bytes = read_whole_file(path, kMostBytes);
    if (is_tiff(bytes)) {
      std::visit(take, decode_tiff(bytes, path));
    } else if (bytes.starts_with("Pf")) {
      take(decode_pfm(bytes, path));
    } else {
      take(decode_image(bytes, path));
    }
  } catch (const DataError& error) {
    size.problem = error.what();
  }
  return size;
}

}  // namespace

void CameraCollector::add(const RgbdFrame& frame) {
  frames_.add(frame.stamp);
  if (!frame.depth_path.empty()) {
    depth_.add(frame.stamp);
    if (first_depth_.depth_path.empty()) first_depth_ = frame;
  }
  if (!frame.colour_path.empty()) {
    colour_.add(frame.colour_stamp);
    if (first_colour_.colour_path.empty()) first_colour_ = frame;
  }
  if (frame.depth_path.empty() || frame.colour_path.empty()) return;
  ++summary_.pairs;
  const double offset_s = (frame.colour_stamp - frame.stamp).seconds();
  if (std::abs(offset_s) > std::abs(summary_.largest_offset_s)) {
    summary_.largest_offset_s = offset_s;
  }
  if (offsets_s_.size() < TimingCollector::kMostIntervals) {
    offsets_s_.push_back(static_cast<float>(offset_s));
  }
}

CameraSummary CameraCollector::finish(const PictureStore* pictures) {
  summary_.frames = frames_.finish();
  summary_.depth = depth_.finish();
  summary_.colour = colour_.finish();
  summary_.median_offset_s = static_cast<double>(median_of(offsets_s_));
  summary_.depth_size = size_of(
      first_depth_.depth_path, pictures, first_depth_.depth_message,
      [&](const PictureStore& store) { return store.depth(first_depth_.depth_message, {}); });
  summary_.colour_size = size_of(
      first_colour_.colour_path, pictures, first_colour_.colour_message,
      [&](const PictureStore& store) { return store.colour(first_colour_.colour_message); });
  return summary_;
}

}  // namespace loopstone
