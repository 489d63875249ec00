#include "loopstone/mapping/occupancy_tiles.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

using Where = OccupancyTiles::DrawWhere;
constexpr double kFootprintM = 0.25;

/// A drive through a furnished room, as scans with poses; the sweep takes time.
struct Scene {
  std::vector<LaserScan> scans{};
  std::vector<PosedScan> posed{};

  Scene() {
    Rng rng(3);
    const auto poses =
        test::drive_through({{1.0, 1.0}, {4.5, 1.2}, {5.0, 4.0}, {1.5, 4.5}}, 0.2, 0.2);
    const test::Scanner scanner{
        .angle_increment_rad = radians(1.0), .beams = 271, .range_max_m = 20.0, .noise_m = 0.02};
    for (const Pose2& pose : poses)
      scans.push_back(test::scan_from(test::furnished_room(), pose, {}, scanner, &rng));
    for (std::size_t i = 0; i < scans.size(); ++i)
      posed.push_back({&scans[i], poses[i], poses[i] * Pose2{0.02, 0.0, 0.01}, poses[i]});
  }
};

void expect_same(const OccupancyMap& a, const OccupancyMap& b) {
  const GridFrame& frame = a.log_odds.frame();
  int compared = 0;
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      const Cell cell{column, row};
      const Cell other = b.log_odds.frame().cell_of(frame.centre_of(cell));
      if (!b.log_odds.frame().contains(other)) {
        EXPECT_EQ(a.observed[cell], 0) << column << ' ' << row;
        continue;
      }
      ASSERT_EQ(a.observed[cell], b.observed[other]) << column << ' ' << row;
      ASSERT_EQ(a.log_odds[cell], b.log_odds[other]) << column << ' ' << row;
      ++compared;
    }
  }
  EXPECT_GT(compared, 1000);
}

TEST(OccupancyTiles, DrawnInOneGoTheyAreTheMap) {
  const Scene scene;
  OccupancyTiles tiles({}, kFootprintM);
  const auto drawn = tiles.draw(scene.posed, Where::kAnywhere, {});
  EXPECT_EQ(tiles.finish_drawing(), drawn.size());
  EXPECT_EQ(drawn, tiles.tiles_of(scene.posed, {}));
  const OccupancyMap map = build_occupancy_map(scene.posed, kFootprintM);
  expect_same(map, tiles.whole());
  expect_same(tiles.whole(), map);
}

TEST(OccupancyTiles, InParts) {
  const Scene scene;
  OccupancyTiles tiles({}, kFootprintM);
  std::optional<Eigen::Vector2d> before;
  for (const PosedScan& one : scene.posed) {
    (void)tiles.draw(std::span(&one, 1), Where::kAnywhere, before);
    (void)tiles.finish_drawing();
    before = one.map_T_robot.translation();
  }
  expect_same(build_occupancy_map(scene.posed, kFootprintM), tiles.whole());
}

TEST(OccupancyTiles, ErasedTilesAreDrawnAnewAndTheOthersStay) {
  const Scene scene;
  OccupancyTiles tiles({}, kFootprintM);
  const auto all = tiles.draw(scene.posed, Where::kAnywhere, {});
  (void)tiles.finish_drawing();
  const OccupancyMap map = tiles.whole();
  ASSERT_GT(all.size(), 4U);
  const std::vector<TileId> some{all[1], all[3]};
  tiles.erase(some);
  EXPECT_EQ(tiles.draw(scene.posed, Where::kErased, {}), some);
  EXPECT_EQ(tiles.finish_drawing(), 2U);
  expect_same(map, tiles.whole());
  const auto newer = tiles.tiles_since(1);
  ASSERT_EQ(newer.size(), 2U);
  EXPECT_EQ(newer[0].id, some[0]);
  EXPECT_EQ(newer[1].id, some[1]);
  EXPECT_TRUE(tiles.tiles_since(2).empty());
  EXPECT_EQ(tiles.tiles_since(0).size(), all.size());
}

TEST(OccupancyTiles, TilesDrawnBesideTakeThePlacesOfThoseThatAreShown) {
  const Scene scene;
  const auto first_half = std::span(scene.posed).first(scene.posed.size() / 2);
  OccupancyTiles tiles({}, kFootprintM);
  (void)tiles.draw(first_half, Where::kAnywhere, {});
  (void)tiles.finish_drawing();
  const auto all = tiles.tiles_of(scene.posed, {});
  OccupancyTiles beside({}, kFootprintM);
  beside.erase(all);
  EXPECT_EQ(beside.draw(scene.posed, Where::kErased, {}), all);
  tiles.replace_by(std::move(beside));
  EXPECT_EQ(tiles.finish_drawing(), all.size());
  expect_same(build_occupancy_map(scene.posed, kFootprintM), tiles.whole());
  // They are as good as if they had been drawn there: more goes on top.
  EXPECT_TRUE(tiles.draw(first_half, Where::kErased, {}).empty());
  EXPECT_FALSE(tiles.draw(first_half, Where::kAnywhere, {}).empty());
}

TEST(OccupancyTiles, ErasedAndNotDrawnIsUnknown) {
  const Scene scene;
  OccupancyTiles tiles({}, kFootprintM);
  const auto all = tiles.draw(scene.posed, Where::kAnywhere, {});
  tiles.erase(all);
  (void)tiles.finish_drawing();
  const OccupancyMap map = tiles.whole();
  EXPECT_EQ(map.log_odds.frame().cell_count(), 1U);
  EXPECT_EQ(map.observed.cells().front(), 0);
}

TEST(OccupancyTiles, ScansThatCannotBePlacedAreLeftOut) {
  Scene scene;
  for (PosedScan& posed : scene.posed) posed.map_T_robot.x = std::nan("");
  scene.posed[1].map_T_robot = scene.posed[1].map_T_lidar = scene.posed[1].map_T_lidar_end =
      Pose2{1e7, 0.0, 0.0};
  OccupancyTiles tiles({}, kFootprintM);
  EXPECT_TRUE(tiles.draw(scene.posed, Where::kAnywhere, {}).empty());
  EXPECT_EQ(tiles.finish_drawing(), 0U);
}

}  // namespace
}  // namespace loopstone
