#include "loopstone/formats/texture_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using testing::HasSubstr;

const GridFrame kFrame{
    .origin = {-12.345678901234, 1.0 / 3.0}, .resolution = 0.01, .columns = 640, .rows = 480};

TEST(TextureYaml, WhatIsWrittenReadsBackTheSame) {
  const TextureInfo info =
      parse_texture_yaml(format_texture_yaml(kFrame, "texture.png", "coverage.png"));
  EXPECT_EQ(info.image, "texture.png");
  EXPECT_EQ(info.coverage, "coverage.png");
  const GridFrame frame = info.frame(640, 480);
  EXPECT_EQ(frame.origin, kFrame.origin);
  EXPECT_EQ(frame.resolution, kFrame.resolution);
  EXPECT_EQ(frame.columns, 640);
  EXPECT_EQ(frame.rows, 480);
  EXPECT_EQ(parse_texture_yaml(format_texture_yaml(kFrame, "t.png")).coverage, std::nullopt);
}

TEST(TextureYaml, NamesAreRelativeToTheFile) {
  const test::TempDir dir;
  const std::string path =
      dir.write("texture.yaml", format_texture_yaml(kFrame, "texture.png", "/elsewhere/c.png"));
  EXPECT_EQ(read_texture_yaml(path).image, dir / "texture.png");
  EXPECT_EQ(read_texture_yaml(path).coverage, "/elsewhere/c.png");
  EXPECT_THROW((void)read_texture_yaml(dir / "none.yaml"), DataError);
}

TEST(TextureYaml, HasTheKeysOfAMap) {
  // A map's file is a texture's file, too: the shared keys mean the same.
  const TextureInfo info = parse_texture_yaml(format_map_yaml(kFrame, "map.pgm"));
  EXPECT_EQ(info.map_T_corner.x, kFrame.origin.x());
  EXPECT_EQ(info.resolution_m, 0.01);
}

TEST(TextureYaml, DamageIsNamedWithItsLine) {
  const auto error = [](const std::string& text) -> std::string {
    try {
      (void)parse_texture_yaml(text, "t");
    } catch (const DataError& caught) {
      return caught.what();
    }
    return "no error";
  };
  EXPECT_THAT(error(""), HasSubstr("no map's YAML"));
  EXPECT_THAT(error("image: a.png\n"), HasSubstr("resolution"));
  EXPECT_THAT(error("image: a.png\nresolution: -1\norigin: [0, 0, 0]"), HasSubstr("t:2"));
  EXPECT_THAT(error("image: a.png\nresolution: 1\norigin: [0, 0]"), HasSubstr("t:3: 'origin'"));
  EXPECT_THAT(error("image: [a]\nresolution: 1\norigin: [0, 0, 0]"), HasSubstr("t:1: 'image'"));
  EXPECT_THAT(error("image: a\ncoverage: {b: c}\nresolution: 1\norigin: [0, 0, 0]"),
              HasSubstr("t:2: 'coverage'"));
  EXPECT_THAT(error("image: ]\n"), HasSubstr("valid YAML"));
  const std::string good = format_texture_yaml(kFrame, "texture.png", "coverage.png");
  Rng rng(2);
  for (int i = 0; i < 1000; ++i) {
    std::string damaged = good;
    damaged[rng.below(damaged.size())] ^= static_cast<char>(1U << rng.below(7));
    try {
      (void)parse_texture_yaml(damaged);
    } catch (const DataError&) {
      continue;
    }
  }
  TextureInfo turned = parse_texture_yaml(good);
  turned.map_T_corner.yaw = 0.5;
  EXPECT_THROW((void)turned.frame(1, 1), UsageError);
}

/// The law: the world file sends the centre of the pixel (column, row from the top) where GridFrame
/// says its cell is.
TEST(WorldFile, AgreesWithTheGrid) {
  std::istringstream text(format_world_file(kFrame));
  std::vector<double> values(6);
  for (double& value : values) text >> value;
  ASSERT_TRUE(text);
  const auto& [a, d, b, e, c, f] =
      std::tie(values[0], values[1], values[2], values[3], values[4], values[5]);
  for (const int column : {0, 7, 639}) {
    for (const int row_from_top : {0, 100, 479}) {
      const Eigen::Vector2d centre = kFrame.centre_of({column, kFrame.rows - 1 - row_from_top});
      EXPECT_NEAR(a * column + b * row_from_top + c, centre.x(), 1e-9);
      EXPECT_NEAR(d * column + e * row_from_top + f, centre.y(), 1e-9);
    }
  }
  EXPECT_LT(e, 0.0);
}

}  // namespace
}  // namespace loopstone
