#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "html_check.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/report/map_outputs.hpp"
#include "loopstone/report/quality_picture.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using test::TempDir;

/// A room, its places, and a verdict.
MapResult judged_result() {
  MapResult result;
  static const LaserScan scan = [] {
    LaserScan made;
    made.angle_min_rad = -kPi;
    made.angle_increment_rad = kPi / 180.0;
    made.range_max_m = 20.0;
    made.ranges_m.assign(360, 4.0F);
    return made;
  }();
  std::vector<PosedScan> posed;
  for (int i = 0; i < 10; ++i) {
    const Pose2 pose{0.05 * i, 0.0, 0.0};
    result.trajectory.append(Stamp{1'000'000'000 + i * 100'000'000LL}, pose);
    posed.push_back({&scan, pose, pose, pose});
  }
  result.map = build_occupancy_map(posed, 0.25);
  result.quality.walls_compared = 1000;
  result.quality.beams_tested = 5000;
  result.quality.crossed_share = 0.5;
  result.quality.places = {
      {.centre = {4.25F, 0.25F}, .compared = 9, .offset_m = 0.01F},
      {.centre = {-3.75F, 0.25F}, .compared = 9, .offset_m = 0.07F},
      {.centre = {0.25F, 3.75F}, .compared = 9, .offset_m = 0.3F, .beams = 20, .crossed = 15},
      {.centre = {0.25F, -3.75F}}};
  result.verdict = judge_map(result);
  return result;
}

TEST(QualityOutputs, SummaryHasEveryMeasureWithItsVerdict) {
  const MapResult result = judged_result();
  const auto quality = nlohmann::json::parse(format_summary(result, {}))["quality"];
  EXPECT_EQ(quality["verdict"], "bad");
  EXPECT_EQ(quality["places"], 4);
  EXPECT_EQ(quality["places_revisited"], 3);
  EXPECT_EQ(quality["places_in_trouble"], 1);
  ASSERT_EQ(quality["measures"].size(), 11U);
  for (const auto& [name, measure] : quality["measures"].items()) {
    EXPECT_TRUE(measure["verdict"].is_string()) << name;
    EXPECT_FALSE(measure["sentence"].get<std::string>().empty()) << name;
    EXPECT_EQ(measure["value"].is_null(), measure["verdict"] == "unknown") << name;
  }
  EXPECT_EQ(quality["measures"]["free_space_violations"]["value"], 0.5);
  EXPECT_TRUE(quality["certificate"].is_null());
  EXPECT_TRUE(quality["entropy_nats"].is_null()) << "nothing was measured";
}

TEST(QualityOutputs, ReportSaysHowGoodTheMapIsAndShowsWhere) {
  const TempDir dir;
  const MapResult result = judged_result();
  write_map_outputs(result, {}, dir / "out");
  EXPECT_EQ(read_image(dir / "out/quality.png").channels, 3);
  const std::string html = dir.read("out/report.html");
  EXPECT_NE(html.find("How good is this map?"), std::string::npos);
  for (const QualityMeasure& measure : result.verdict.measures)
    EXPECT_NE(html.find(measure.title), std::string::npos) << measure.title;
  EXPECT_NE(html.find("state lost\">bad</span> Look at free-space violations."), std::string::npos);
  EXPECT_NE(html.find("state unknown\">not known"), std::string::npos);
  EXPECT_NE(html.find("3 of 4 places"), std::string::npos);
  test::expect_self_contained(html);
}

TEST(QualityOutputs, AResultThatWasNotJudgedHasNoSection) {
  const TempDir dir;
  MapResult result = judged_result();
  result.verdict = {};
  write_map_outputs(result, {}, dir / "out");
  EXPECT_FALSE(std::filesystem::exists(dir / "out/quality.png"));
  EXPECT_EQ(dir.read("out/report.html").find("How good"), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(format_summary(result, {}))["quality"]["verdict"], "unknown");
}

/// Pixels that are clearly of a colour: red over blue, or blue over red.
struct Tints {
  std::size_t warm = 0;
  std::size_t cold = 0;
};
Tints tints_of(const Image& image) {
  Tints tints;
  for (std::size_t i = 0; i + 2 < image.bytes.size(); i += 3) {
    const int red = image.bytes[i];
    const int blue = image.bytes[i + 2];
    if (red > blue + 40) ++tints.warm;
    if (blue > red + 40) ++tints.cold;
  }
  return tints;
}

TEST(QualityPicture, ShowsTroubleInWarmColoursAndAgreementInBlue) {
  MapResult result = judged_result();
  const Tints mixed = tints_of(draw_quality_picture(result));
  for (QualityPlace& place : result.quality.places) place.offset_m = 0.3F;
  const Tints bad = tints_of(draw_quality_picture(result));
  for (QualityPlace& place : result.quality.places)
    place = {.centre = place.centre, .compared = 9, .offset_m = 0.01F};
  const Tints good = tints_of(draw_quality_picture(result));
  EXPECT_GT(bad.warm, mixed.warm);
  EXPECT_GT(mixed.warm, good.warm);
  EXPECT_GT(good.cold, mixed.cold);
  EXPECT_GT(mixed.cold, bad.cold);
  result.map = {};
  result.trajectory = {};
  EXPECT_GT(draw_quality_picture(result).width, 0) << "an empty map is no reason to fail";
}

}  // namespace
}  // namespace loopstone
