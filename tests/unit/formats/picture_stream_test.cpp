// Frames out of two streams of pictures.

#include "formats/picture_stream.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "formats/picture_pairs.hpp"

namespace loopstone {
namespace {

Stamp ms(double value) { return Stamp{static_cast<std::int64_t>(1e6 * value)}; }

struct Came {
  Stamp stamp{};
  bool is_depth = false;
  std::int64_t number = 0;
};

std::vector<RgbdFrame> frames_of(const std::vector<Came>& pictures) {
  PictureStream stream("/depth", "/colour");
  std::vector<RgbdFrame> frames;
  const auto take = [&](bool at_end) {
    for (RgbdFrame& frame : stream.take(at_end)) frames.push_back(std::move(frame));
  };
  for (const Came& picture : pictures) {
    if (picture.is_depth) {
      stream.add_depth(picture.stamp, picture.number);
    } else {
      stream.add_colour(picture.stamp, picture.number);
    }
    take(false);
  }
  take(true);
  return frames;
}

TEST(PictureStream, AgreesWithPairingAllAtOnce) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> jitter(-9.0, 9.0);
    std::vector<Came> pictures;
    std::vector<Stamp> depths;
    std::vector<Stamp> colours;
    for (int i = 0; i < 600; ++i) {  // 20 s of pictures, some of them lost
      const double t = 33.3 * i;
      if (random() % 10 != 0) {
        depths.push_back(ms(t + jitter(random)));
        pictures.push_back({depths.back(), true, static_cast<std::int64_t>(depths.size()) - 1});
      }
      if (random() % 10 != 0) {
        colours.push_back(ms(t + 8 + jitter(random)));
        pictures.push_back({colours.back(), false, static_cast<std::int64_t>(colours.size()) - 1});
      }
    }
    // Up to a tenth of a second late.
    std::ranges::stable_sort(pictures, {}, [&](const Came& picture) {
      return (picture.stamp.nanoseconds + (random() % 2 == 0 ? 100'000'000 : 0)) / 200'000'000;
    });
    std::set<std::pair<std::int64_t, std::int64_t>> found;
    for (const RgbdFrame& frame : frames_of(pictures)) {
      found.emplace(frame.depth_message, frame.colour_message);
    }
    std::set<std::pair<std::int64_t, std::int64_t>> expected;
    const auto number = [](const std::optional<std::size_t>& i) {
      return i ? static_cast<std::int64_t>(*i) : std::int64_t{-1};
    };
    for (const PicturePair& pair :
         pair_pictures(depths, colours, longest_pair_offset(depths, colours))) {
      expected.emplace(number(pair.depth), number(pair.colour));
    }
    EXPECT_EQ(found, expected) << seed;
  }
}

TEST(PictureStream, GivesFramesByStampAndNamesTheirSources) {
  const auto frames = frames_of({{ms(100), false, 0}, {ms(90), true, 0}, {ms(400), true, 1}});
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].stamp, ms(90));
  EXPECT_EQ(frames[0].colour_stamp, ms(100));
  EXPECT_EQ(frames[0].depth_path, "/depth");
  EXPECT_EQ(frames[0].colour_path, "/colour");
  EXPECT_EQ(frames[1].stamp, ms(400));
  EXPECT_EQ(frames[1].colour_path, "");
  EXPECT_EQ(frames[1].colour_message, -1);
}

TEST(PictureStream, OfTwoPicturesWithOneStampTheFirstCounts) {
  const auto frames = frames_of({{ms(5), true, 3}, {ms(5), true, 4}, {ms(5), false, 5}});
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].depth_message, 3);
  EXPECT_EQ(frames[0].colour_message, 5);
}

}  // namespace
}  // namespace loopstone
