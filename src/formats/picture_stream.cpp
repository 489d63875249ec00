#include "formats/picture_stream.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "formats/picture_pairs.hpp"

namespace loopstone {
namespace {

/// A partner comes at most so much later: recorders write pictures of one moment far apart.
constexpr Duration kSettled{2'000'000'000};
/// Pairs are made when so much has gathered.
constexpr Duration kGathered{2 * kSettled.nanoseconds};

}  // namespace

void PictureStream::add(Picture picture, std::vector<Picture>& stream) {
  const auto at = std::ranges::lower_bound(stream, picture.stamp, {}, &Picture::stamp);
  if (at != stream.end() && at->stamp == picture.stamp) return;
  stream.insert(at, picture);
  if (depth_.size() + colour_.size() == 1) newest_ = picture.stamp;
  newest_ = std::max(newest_, picture.stamp);
}

std::vector<RgbdFrame> PictureStream::take(bool at_end) {
  std::vector<RgbdFrame> frames;
  if (depth_.empty() && colour_.empty()) return frames;
  const auto first_of = [&](const std::vector<Picture>& stream) {
    return stream.empty() ? newest_ : stream.front().stamp;
  };
  const Stamp oldest = std::min(first_of(depth_), first_of(colour_));
  if (!at_end && newest_ - oldest < kGathered) return frames;

  const auto stamps_of = [](const std::vector<Picture>& stream) {
    std::vector<Stamp> stamps;
    for (const Picture& picture : stream) stamps.push_back(picture.stamp);
    return stamps;
  };
  const std::vector<Stamp> depths = stamps_of(depth_);
  const std::vector<Stamp> colours = stamps_of(colour_);
  std::vector<bool> depth_is_used(depth_.size(), false);
  std::vector<bool> colour_is_used(colour_.size(), false);
  for (const PicturePair& pair :
       pair_pictures(depths, colours, longest_pair_offset(depths, colours))) {
    RgbdFrame frame;
    if (pair.depth) {
      frame.depth_path = depth_source_;
      frame.depth_message = depth_[*pair.depth].message;
    }
    if (pair.colour) {
      frame.colour_path = colour_source_;
      frame.colour_message = colour_[*pair.colour].message;
      frame.colour_stamp = colours[*pair.colour];
    }
    frame.stamp = pair.depth ? depths[*pair.depth] : frame.colour_stamp;
    if (!at_end && newest_ - frame.stamp < kSettled) continue;
    if (pair.depth) depth_is_used[*pair.depth] = true;
    if (pair.colour) colour_is_used[*pair.colour] = true;
    frames.push_back(std::move(frame));
  }
  const auto drop_used = [](std::vector<Picture>& stream, const std::vector<bool>& is_used) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < stream.size(); ++i) {
      if (!is_used[i]) stream[kept++] = stream[i];
    }
    stream.resize(kept);
  };
  drop_used(depth_, depth_is_used);
  drop_used(colour_, colour_is_used);
  return frames;
}

}  // namespace loopstone
