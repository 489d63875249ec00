#include "loopstone/report/texture_outputs.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "html_check.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/texture_files.hpp"
#include "loopstone/report/map_outputs.hpp"
#include "loopstone/report/texture_picture.hpp"
#include "support/temp_dir.hpp"
#include "texture_scene.hpp"

namespace loopstone {
namespace {

using test::TempDir;
using test::texture_info;
using test::texture_path;
using test::texture_scene;
using testing::HasSubstr;
namespace fs = std::filesystem;

const std::vector<std::string> kTextureFiles{"coverage.png", "texture.pgw", "texture.png",
                                             "texture.yaml"};

std::vector<std::string> names_in(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    names.push_back(entry.path().filename());
  }
  std::sort(names.begin(), names.end());
  return names;
}

TEST(TextureOutputs, PicturesHoldEveryCell) {
  const TempDir dir;
  const FloorTexture texture = texture_scene();
  write_texture_outputs(texture, {}, texture_path(), texture_info(), dir / "out");
  EXPECT_EQ(names_in(dir / "out"),
            (std::vector<std::string>{"coverage.png", "options.toml", "summary.json", "texture.pgw",
                                      "texture.png", "texture.yaml", "texture_map.png"}));
  const Image picture = read_image(dir / "out/texture.png");
  const Image coverage = read_image(dir / "out/coverage.png");
  ASSERT_EQ(picture.width, texture.frame.columns);
  ASSERT_EQ(picture.height, texture.frame.rows);
  ASSERT_EQ(picture.channels, 4);
  ASSERT_EQ(coverage.width, texture.frame.columns);
  ASSERT_EQ(coverage.height, texture.frame.rows);
  ASSERT_EQ(coverage.channels, 1);
  for (int row = 0; row < picture.height; ++row) {
    for (int column = 0; column < picture.width; ++column) {
      const TextureColour truth =
          test::texture_scene_at({column, texture.frame.rows - 1 - row});  // row 0 is the top
      ASSERT_EQ(picture.sample(row, column, 0), truth.red) << row << " " << column;
      ASSERT_EQ(picture.sample(row, column, 1), truth.green);
      ASSERT_EQ(picture.sample(row, column, 2), truth.blue);
      ASSERT_EQ(picture.sample(row, column, 3) > 0, truth.coverage > 0);
      ASSERT_EQ(coverage.sample(row, column), truth.coverage);
    }
  }
  // The lone cell on the very upper right: neither turned nor mirrored.
  EXPECT_EQ(coverage.sample(0, picture.width - 1), 255);
  EXPECT_EQ(coverage.sample(picture.height - 1, picture.width - 1), 0);
  EXPECT_EQ(dir.read("out/options.toml"), texture_info().options_toml);
}

TEST(TextureOutputs, FrameReadsBackAndTheWorldFileIsRight) {
  const TempDir dir;
  const FloorTexture texture = texture_scene();
  write_texture_outputs(texture, {}, texture_path(), texture_info(), dir / "out");
  const TextureInfo info = read_texture_yaml(dir / "out/texture.yaml");
  EXPECT_EQ(info.image, dir / "out/texture.png");
  EXPECT_EQ(info.coverage, dir / "out/coverage.png");
  EXPECT_EQ(info.frame(test::kTextureColumns, test::kTextureRows), texture.frame);
  // A D B E C F: metres a pixel, no rotation, and the middle of the upper left pixel: -0.6 + 0.01,
  // 1.7 + 40 * 0.02 - 0.01.
  const std::string world = dir.read("out/texture.pgw");
  std::vector<double> values;
  std::istringstream lines(world);
  for (double value = 0.0; lines >> value;) values.push_back(value);
  ASSERT_EQ(values.size(), 6U) << world;
  const std::vector<double> by_hand{0.02, 0.0, 0.0, -0.02, -0.59, 2.49};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(values[i], by_hand[i], 1e-12) << i;
}

TEST(TextureOutputs, SummaryHasEveryFigure) {
  const auto summary =
      nlohmann::json::parse(format_texture_summary(texture_scene(), texture_info()));
  EXPECT_EQ(summary.at("version"), "9.8.7");
  EXPECT_EQ(summary.at("log"), "/logs/a&b");
  EXPECT_EQ(summary.at("complete"), true);
  EXPECT_EQ(summary.at("resolution_m"), 0.02);
  EXPECT_EQ(summary.at("columns"), test::kTextureColumns);
  EXPECT_EQ(summary.at("rows"), test::kTextureRows);
  EXPECT_EQ(summary.at("frames"), 120);
  EXPECT_EQ(summary.at("frames_used"), 100);
  EXPECT_EQ(summary.at("frames_still"), 15);
  EXPECT_EQ(summary.at("frames_without_pose"), 2);
  EXPECT_EQ(summary.at("frames_tilted"), 0);
  EXPECT_EQ(summary.at("frames_unreadable"), 3);
  EXPECT_EQ(summary.at("seen_area_m2"), 0.5604);
  EXPECT_EQ(summary.at("filled_area_m2"), 0.016);
  EXPECT_EQ(summary.at("cloud_points"), 0);
  EXPECT_EQ(summary.at("floor").at("status"), "estimated");
  EXPECT_NEAR(summary.at("floor").at("pitch_error_deg").get<double>(), 1.25, 1e-12);
  EXPECT_NEAR(summary.at("floor").at("roll_error_deg").get<double>(), -0.5, 1e-12);
  EXPECT_EQ(summary.at("floor").at("height_error_m"), 0.004);
  EXPECT_EQ(summary.at("clock").at("status"), "estimated");
  EXPECT_EQ(summary.at("clock").at("late_s"), 0.05);
  EXPECT_EQ(summary.at("clock").at("significant"), true);
  EXPECT_EQ(summary.at("warnings").at(0), "the mount <differs>");
}

TEST(TextureOutputs, CloudIsWrittenWhenThereIsOne) {
  const TempDir dir;
  FloorTexture texture = texture_scene();
  texture.cloud = {{{1.0F, 2.0F, 3.0F}, {10, 20, 30}}, {{4.0F, 5.0F, 6.0F}, {40, 50, 60}}};
  write_texture_outputs(texture, {}, texture_path(), texture_info(), dir / "out");
  EXPECT_THAT(dir.read("out/cloud.ply"), HasSubstr("element vertex 2\n"));
}

TEST(TextureOutputs, ARefusedFolderIsLeftAsItWas) {
  const TempDir dir;
  fs::create_directory(dir / "out");
  dir.write("out/precious.txt", "x");
  RunInfo info = texture_info();
  EXPECT_THROW(write_texture_outputs(texture_scene(), {}, texture_path(), info, dir / "out"),
               UsageError);
  EXPECT_EQ(names_in(dir / "out"), std::vector<std::string>{"precious.txt"});
  EXPECT_EQ(dir.names(), std::vector<std::string>{"out"});
  EXPECT_THROW(
      write_texture_outputs(texture_scene(), {}, texture_path(), info, dir / "out/precious.txt/a"),
      DataError);
  info.force = true;
  write_texture_outputs(texture_scene(), {}, texture_path(), info, dir / "out");
  EXPECT_EQ(dir.read("out/precious.txt"), "x");
  EXPECT_EQ(names_in(dir / "out").size(), 8U);
}

TEST(TextureOutputs, NoFloorSeenStillHasASummary) {
  const TempDir dir;
  write_texture_outputs(FloorTexture{}, {}, {}, RunInfo{}, dir / "out");
  EXPECT_EQ(names_in(dir / "out"), (std::vector<std::string>{"options.toml", "summary.json"}));
  const auto summary = nlohmann::json::parse(dir.read("out/summary.json"));
  EXPECT_EQ(summary.at("floor").at("status"), "not_seen");
  EXPECT_EQ(summary.at("clock").at("status"), "not_observed");
  EXPECT_EQ(summary.at("columns"), 0);
  const Image picture = draw_texture_picture(FloorTexture{}, {}, {});
  EXPECT_GT(picture.width, 0);
}

TEST(TextureOutputs, SameTextureSameBytes) {
  const TempDir dir;
  for (const char* name : {"a", "b"}) {
    write_texture_outputs(texture_scene(), {}, texture_path(), texture_info(), dir / name);
  }
  for (const std::string& name : names_in(dir / "a")) {
    EXPECT_EQ(dir.read("a/" + name), dir.read("b/" + name)) << name;
  }
}

/// A map in which everything is free, but for a wall on the right of the texture.
MapResult walled_map() {
  MapResult result;
  result.trajectory = texture_path();
  result.odometry = texture_path();
  const GridFrame frame{.origin = {-0.7, 1.6}, .resolution = 0.05, .columns = 34, .rows = 20};
  result.map = {Grid<float>(frame, -4.0F), Grid<std::uint8_t>(frame, 1)};
  for (int row = 0; row < frame.rows; ++row) result.map.log_odds[{10, row}] = 4.0F;
  return result;
}

TEST(TextureOutputs, AMapsReportHasTheFloor) {
  const TempDir dir;
  const FloorTexture texture = texture_scene();
  write_map_outputs(walled_map(), texture_info(), dir / "with", {&texture});
  write_map_outputs(walled_map(), texture_info(), dir / "without");
  std::vector<std::string> more;
  const std::vector<std::string> with = names_in(dir / "with");
  const std::vector<std::string> without = names_in(dir / "without");
  std::set_difference(with.begin(), with.end(), without.begin(), without.end(),
                      std::back_inserter(more));
  EXPECT_THAT(more, testing::IsSupersetOf(kTextureFiles));
  EXPECT_TRUE(std::includes(with.begin(), with.end(), without.begin(), without.end()));
  const std::string html = dir.read("with/report.html");
  EXPECT_THAT(html, HasSubstr("<h2>Floor</h2>"));
  EXPECT_THAT(html, HasSubstr("+1.25 deg"));
  EXPECT_THAT(html, HasSubstr("+50.0 ± 2.0 ms, corrected"));
  test::expect_self_contained(html);
  EXPECT_THAT(dir.read("without/report.html"), testing::Not(HasSubstr("<h2>Floor</h2>")));
  const auto summary = nlohmann::json::parse(dir.read("with/summary.json"));
  EXPECT_EQ(summary.at("texture").at("frames_used"), 100);
  EXPECT_NEAR(summary.at("texture").at("floor").at("pitch_error_deg").get<double>(), 1.25, 1e-12);
  EXPECT_FALSE(nlohmann::json::parse(dir.read("without/summary.json")).contains("texture"));
}

TEST(TextureOutputs, AMapsReportWithoutFloorSaysSo) {
  const TempDir dir;
  const FloorTexture empty;
  write_map_outputs(walled_map(), texture_info(), dir / "out", {&empty});
  const std::string html = dir.read("out/report.html");
  EXPECT_THAT(html, HasSubstr("show no floor that could be put on the map"));
  test::expect_self_contained(html);
  EXPECT_FALSE(fs::exists(dir / "out/texture.png"));
  EXPECT_EQ(nlohmann::json::parse(dir.read("out/summary.json")).at("texture").at("columns"), 0);
}

TEST(TexturePicture, ShowsFloorAndWalls) {
  FloorTexture texture = texture_scene();
  for (int row = 0; row < test::kTextureRows; ++row) {
    for (int column = 0; column < test::kTextureColumns; ++column) {
      texture.cells.at({column - 30, row + 85}) = {200, 30, 30, TextureColour::kSeen};
    }
  }
  TexturePictureOptions options;
  options.trajectory = false;
  const auto count = [&](const Image& picture, int red, int green) {
    int pixels = 0;
    for (int row = 0; row < picture.height; ++row) {
      for (int column = 0; column < picture.width; ++column) {
        if (std::abs(picture.sample(row, column, 0) - red) <= 3 &&
            std::abs(picture.sample(row, column, 1) - green) <= 3) {
          ++pixels;
        }
      }
    }
    return pixels;
  };
  const Image alone = draw_texture_picture(texture, {}, texture_path(), options);
  const Image walled = draw_texture_picture(texture, walled_map().map, texture_path(), options);
  EXPECT_EQ(alone.channels, 3);
  EXPECT_GT(count(alone, 200, 30), alone.width * alone.height / 3);
  EXPECT_GT(count(walled, 200, 30), walled.width * walled.height / 5);
  EXPECT_GT(count(walled, 0x16, 0x1b), walled.width * walled.height / 120);
  // The path is drawn over the floor.
  const Image with_path = draw_texture_picture(texture, {}, texture_path());
  EXPECT_LT(count(with_path, 200, 30), count(alone, 200, 30));
}

}  // namespace
}  // namespace loopstone
