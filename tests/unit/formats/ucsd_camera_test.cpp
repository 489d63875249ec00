// Camera frames in the UCSD layout: pairing, gaps, copies.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/picture_pairs.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/formats/convert_log.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/log_format.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/log_summary.hpp"
#include "support/read_log.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;
using test::LogContent;
using test::TempDir;

Stamp ms(double milliseconds) { return Stamp::from_seconds(1000.0 + milliseconds * 1e-3); }

std::vector<Stamp> row(const std::vector<double>& milliseconds) {
  std::vector<Stamp> stamps;
  for (const double at : milliseconds) stamps.push_back(ms(at));
  return stamps;
}

TEST(UcsdPairs, TheNearestServesAndServesOnce) {
  const auto depth = row({0, 33, 66, 100});
  const auto colour = row({-20, 10, 30, 34, 101, 300});
  const auto pairs = pair_pictures(depth, colour, Duration{50'000'000});
  // 33 takes 34 and 100 takes 101. 66 could only have 30, and the streams would cross: it stays
  // alone.
  using Place = std::optional<std::size_t>;
  constexpr std::nullopt_t kAlone = std::nullopt;
  std::vector<std::pair<Place, Place>> got;
  for (const PicturePair& pair : pairs) got.emplace_back(pair.depth, pair.colour);
  const std::vector<std::pair<Place, Place>> wanted{{kAlone, 0}, {0, 1}, {kAlone, 2}, {1, 3},
                                                    {2, kAlone}, {3, 4}, {kAlone, 5}};
  EXPECT_EQ(got, wanted);
}

TEST(UcsdPairs, LimitFollowsTheSlowerStream) {
  EXPECT_EQ(longest_pair_offset({}, {}), Duration{50'000'000});
  EXPECT_EQ(longest_pair_offset(row({0, 33, 66}), row({0, 33})), Duration{50'000'000});
  EXPECT_EQ(longest_pair_offset(row({0, 33, 66}), row({0, 200, 400})), Duration{100'000'000});
  EXPECT_EQ(longest_pair_offset(row({0, 2000}), row({0, 33})), Duration{250'000'000});
}

/// The naive twin: all candidates by their distance, each checked against all pairs so far.
std::vector<std::optional<std::size_t>> colour_of_each(const std::vector<Stamp>& depth,
                                                       const std::vector<Stamp>& colour,
                                                       Duration limit) {
  std::vector<std::array<std::int64_t, 3>> candidates;
  for (std::size_t d = 0; d < depth.size(); ++d) {
    for (std::size_t c = 0; c < colour.size(); ++c) {
      const std::int64_t offset = std::abs((depth[d] - colour[c]).nanoseconds);
      if (offset > limit.nanoseconds) continue;
      candidates.push_back({offset, static_cast<std::int64_t>(d), static_cast<std::int64_t>(c)});
    }
  }
  std::sort(candidates.begin(), candidates.end());
  std::vector<std::optional<std::size_t>> colour_of(depth.size());
  for (const auto& [offset, depth_at, colour_at] : candidates) {
    const auto d = static_cast<std::size_t>(depth_at);
    const auto c = static_cast<std::size_t>(colour_at);
    bool fits = true;
    for (std::size_t place = 0; place < depth.size(); ++place) {
      const auto taken = colour_of[place];
      if (taken && (place == d || *taken == c || (place < d) != (*taken < c))) fits = false;
    }
    if (fits) colour_of[d] = c;
  }
  return colour_of;
}

TEST(UcsdPairs, AgreesWithTheNaiveTwinAndLosesNothing) {
  Rng rng(8);
  for (int round = 0; round < 300; ++round) {
    const auto stamps = [&](std::uint64_t spread_ms) {
      std::vector<Stamp> list;
      Stamp at = ms(static_cast<double>(rng.below(100)));
      for (std::uint64_t i = rng.below(30); i > 0; --i) {
        at = at + Duration{1'000'000 * static_cast<std::int64_t>(15 + rng.below(spread_ms))};
        list.push_back(at);
      }
      return list;
    };
    const auto depth = stamps(40);
    const auto colour = stamps(60);
    const Duration limit{50'000'000};
    const auto pairs = pair_pictures(depth, colour, limit);
    std::vector<std::optional<std::size_t>> colour_of(depth.size());
    std::size_t depths = 0;
    std::size_t colours = 0;
    Stamp last{};
    Stamp last_colour{};
    for (const PicturePair& pair : pairs) {
      const Stamp stamp = pair.depth ? depth[*pair.depth] : colour[*pair.colour];
      EXPECT_LT(last, stamp);
      last = stamp;
      if (pair.depth) {
        ++depths;
        colour_of[*pair.depth] = pair.colour;
      }
      if (pair.colour) {
        ++colours;
        EXPECT_LT(last_colour,
                  colour[*pair.colour]);  // so that a writer may number them as they come
        last_colour = colour[*pair.colour];
      }
    }
    EXPECT_EQ(depths, depth.size());
    EXPECT_EQ(colours, colour.size());
    EXPECT_EQ(colour_of, colour_of_each(depth, colour, limit));
  }
}

/// Frames of a depth camera at 30 Hz and a colour camera that runs 12 ms later; picture 3 of colour
/// is lost. Pictures are one pixel that tells its number.
class CameraLog {
 public:
  explicit CameraLog(const std::string& depth_kind = "depth") : kind_(depth_kind) {
    fs::create_directories(folder_ / "in");
    for (int i = 0; i < 6; ++i) {
      const std::string number = std::to_string(i);
      Image depth = make_image(1, 1, 1, 2);
      depth.bytes[0] = static_cast<std::uint8_t>(i);
      write_png(folder_ / ("in/" + kind_ + number + ".png"), depth);
      Image colour = make_image(1, 1, 3);
      colour.bytes[0] = static_cast<std::uint8_t>(100 + i);
      write_png(folder_ / ("in/c" + number + ".png"), colour);
      RgbdFrame frame{ms(33.0 * i), ms(33.0 * i + 12.0), folder_ / ("in/c" + number + ".png"),
                      folder_ / ("in/" + kind_ + number + ".png")};
      if (i == 3) {
        frame.colour_path.clear();
        frame.colour_stamp = frame.stamp;
      }
      frames_.push_back(frame);
    }
  }
  void write(const std::string& name) const {
    const auto writer = create_log(folder_ / name, "ucsd", RobotModel{});
    writer->write(WheelTicks{ms(-1.0), {1, 1, 1, 1}});
    for (const RgbdFrame& frame : frames_) writer->write(frame);
    writer->finish();
  }
  [[nodiscard]] std::string path(const std::string& name) const { return folder_ / name; }

 private:
  TempDir folder_;
  std::string kind_;
  std::vector<RgbdFrame> frames_;
};

int first_byte(const std::string& picture) { return read_image(picture).bytes.at(0); }

void expect_six_frames(const LogContent& log) {
  ASSERT_EQ(log.frames.size(), 6u);
  EXPECT_TRUE(log.in_time_order);
  EXPECT_EQ(log.skipped, 0);
  for (int i = 0; i < 6; ++i) {
    const RgbdFrame& frame = log.frames[static_cast<std::size_t>(i)];
    EXPECT_NEAR(frame.stamp.seconds(), ms(33.0 * i).seconds(), 1e-9);
    EXPECT_EQ(first_byte(frame.depth_path), i);
    if (i == 3) {
      EXPECT_EQ(frame.colour_path, "");
      EXPECT_EQ(frame.colour_stamp, frame.stamp);
    } else {
      EXPECT_NEAR((frame.colour_stamp - frame.stamp).seconds(), 0.012, 1e-9);
      EXPECT_EQ(first_byte(frame.colour_path), 100 + i);
    }
  }
}

TEST(UcsdCamera, PicturesAndBothStampsComeBack) {
  const CameraLog log("disparity");
  log.write("out");
  expect_six_frames(test::read_log(log.path("out")));
  EXPECT_TRUE(fs::exists(log.path("out/dataRGBD/RGB20/rgb20_5.png")));
  EXPECT_FALSE(fs::exists(log.path("out/dataRGBD/RGB20/rgb20_6.png")));
  EXPECT_TRUE(fs::exists(log.path("out/dataRGBD/Disparity20/disparity20_6.png")));
}

TEST(UcsdCamera, ConvertedAgainItIsTheSame) {
  const CameraLog log("disparity");
  log.write("out");
  const auto reader = open_log(log.path("out"));
  const auto writer = create_log(log.path("again"), "ucsd", RobotModel{}, 7);
  const ConvertResult converted =
      convert_log(*reader, *writer, log_format("ucsd").holds, RobotModel{});
  EXPECT_EQ(converted.camera_frames, 6);
  EXPECT_FALSE(fs::exists(log.path("again/dataRGBD/RGB7")));
  writer->finish();
  expect_six_frames(test::read_log(log.path("again")));
  EXPECT_TRUE(fs::exists(log.path("again/dataRGBD/Disparity7/disparity7_1.png")));
  std::size_t entries = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(log.path("again/dataRGBD"))) {
    ++entries;  // nothing hidden is left
  }
  EXPECT_EQ(entries, 2u);
}

TEST(UcsdCamera, PlainDepthHasItsOwnFolder) {
  const CameraLog log("depth");
  log.write("out");
  EXPECT_TRUE(fs::exists(log.path("out/dataRGBD/Depth20/depth20_6.png")));
  expect_six_frames(test::read_log(log.path("out")));
  EXPECT_EQ(open_log(log.path("out"))->robot(RobotModel{}).camera.encoding.kind, DepthKind::kDepth);
  const CameraLog other("disparity");
  other.write("out");
  EXPECT_EQ(open_log(other.path("out"))->robot(RobotModel{}).camera.encoding.kind,
            DepthKind::kDisparity);
}

TEST(UcsdCamera, NothingIsLeftWithoutFinish) {
  const CameraLog log;
  {
    const auto writer = create_log(log.path("out"), "ucsd", RobotModel{});
    writer->write(RgbdFrame{ms(0), ms(0), log.path("in/c0.png"), log.path("in/depth0.png")});
    EXPECT_FALSE(fs::is_empty(log.path("out")));
  }
  EXPECT_TRUE(fs::is_empty(log.path("out")));
  const auto writer = create_log(log.path("out"), "ucsd", RobotModel{});
  EXPECT_THROW(writer->write(RgbdFrame{ms(0), ms(0), log.path("in/none.png"), {}}), DataError);
}

TEST(UcsdCamera, PicturesThatLieAtTheirPlaceStayThere) {
  const CameraLog log("disparity");
  log.write("out");
  const auto reader = open_log(log.path("out"));
  const auto writer = create_log(log.path("out"), "ucsd", RobotModel{});
  (void)convert_log(*reader, *writer, log_format("ucsd").holds, RobotModel{});
  writer->finish();
  expect_six_frames(test::read_log(log.path("out")));
}

TEST(UcsdCamera, LostPicturesAndBrokenStampsAreNamed) {
  const CameraLog log("disparity");
  log.write("out");
  fs::remove(log.path("out/dataRGBD/RGB20/rgb20_1.png"));
  fs::copy(log.path("in/c0.png"), log.path("out/dataRGBD/RGB20/rgb20_6.png"));
  const LogContent content = test::read_log(log.path("out"));
  EXPECT_EQ(content.frames.size(), 6u);
  EXPECT_EQ(content.frames[0].colour_path, "");
  EXPECT_TRUE(content.has_note("1 of 5 colour pictures are not in RGB20"));
  EXPECT_TRUE(content.has_note("1 colour pictures in RGB20 have no stamp"));

  const auto writer = create_log(log.path("late"), "ucsd", RobotModel{});
  writer->write(WheelTicks{ms(-1.0), {1, 1, 1, 1}});
  const std::string depth = log.path("in/disparity0.png");
  for (const double at : {0.0, 33.0, 20.0, 66.0})
    writer->write(RgbdFrame{ms(at), ms(at), {}, depth});
  writer->finish();
  const LogContent late = test::read_log(log.path("late"));
  EXPECT_EQ(late.frames.size(), 3u);
  ASSERT_EQ(late.problems.size(), 1u);
  EXPECT_NE(late.problems[0].reason.find("disparity picture"), std::string::npos)
      << late.problems[0].reason;
}

TEST(UcsdCamera, SummaryTellsOfBothCameras) {
  const CameraLog log("disparity");
  log.write("out");
  const auto reader = open_log(log.path("out"));
  const LogSummary summary = analyse_log(*reader);
  ASSERT_TRUE(summary.camera);
  EXPECT_EQ(summary.camera->frames.records, 6);
  EXPECT_EQ(summary.camera->depth.records, 6);
  EXPECT_EQ(summary.camera->colour.records, 5);
  EXPECT_EQ(summary.camera->pairs, 5);
  EXPECT_NEAR(summary.camera->depth.rate_hz, 1000.0 / 33.0, 1e-3);
  EXPECT_NEAR(summary.camera->largest_offset_s, 0.012, 1e-9);
  EXPECT_NEAR(summary.camera->median_offset_s, 0.012, 1e-9);
  EXPECT_EQ(summary.camera->colour_size.width_px, 1);
  EXPECT_EQ(summary.camera->depth_size.height_px, 1);
}

}  // namespace
}  // namespace loopstone
