// The grids beside the map of a site.

#include "loopstone/report/site_grids.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "loopstone/formats/image.hpp"
#include "loopstone/report/map_outputs.hpp"
#include "report/site_pictures.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using test::TempDir;
using testing::HasSubstr;

constexpr int kSide = 40;
const GridFrame kFrame{.origin = {-1.0, -1.0}, .resolution = 0.05, .columns = kSide, .rows = kSide};

/// A room: a wall on its left, its right half seen by the first session alone, a lane that was
/// driven, a pane in the wall.
struct Room {
  Room() {
    for (int row = 0; row < kSide; ++row) {
      for (int column = 2; column < kSide; ++column) {
        const Cell cell{column, row};
        const bool is_new = column < kSide / 2;
        map.observed[cell] = 1;
        map.log_odds[cell] = column == 2 ? 3.0F : -3.0F;
        grids.coverage.visits[cell] = is_new ? 3 : 1;
        grids.coverage.newest[cell] = is_new ? 3 : 1;
      }
      grids.travel[{10, row}] = {.passes = 250, .timed = 2, .speed_sum_m_s = 1.5F};
      grids.travel[{11, row}] = {.passes = 1};
      grids.glass[{2, row}] = row < 10 ? 0.98F : 0.02F;
    }
    for (const double day : {0.0, 1.0, 9.25})
      grids.coverage.begins.push_back(Stamp::from_seconds(86'400.0 * day));
  }
  OccupancyMap map{Grid<float>(kFrame), Grid<std::uint8_t>(kFrame)};
  SiteGrids grids{.coverage = {Grid<std::uint16_t>(kFrame), Grid<std::uint16_t>(kFrame), {}},
                  .travel = Grid<CellTravel>(kFrame),
                  .glass = Grid<float>(kFrame, -1.0F)};
};

TEST(SiteGrids, FiguresAreThoseOfTheCells) {
  const Room room;
  const SiteFigures figures = figures_of(room.grids, room.map);
  constexpr double kCellM2 = 0.05 * 0.05;
  EXPECT_EQ(figures.sessions, 3U);
  EXPECT_NEAR(figures.floor.free_m2, 37 * kSide * kCellM2, 1e-9);
  EXPECT_NEAR(figures.floor.free_seen_by_newest_m2, 17 * kSide * kCellM2, 1e-9);
  EXPECT_NEAR(figures.floor.free_driven_m2, 2 * kSide * kCellM2, 1e-9);
  EXPECT_EQ(figures.most_passes, 250);
  EXPECT_NEAR(*figures.speed_m_s, 0.75, 1e-6);
  ASSERT_EQ(figures.panes.size(), 1U);
  EXPECT_NEAR(figures.panes.front().length_m(), 0.5, 0.01);
  MapResult result;
  result.map = room.map;
  const auto site = nlohmann::json::parse(format_summary(result, {}, {.site = &figures}))["site"];
  EXPECT_NEAR(site["free_seen_by_newest_share"].get<double>(), 17.0 / 37.0, 1e-9);
  EXPECT_NEAR(site["free_never_driven_share"].get<double>(), 35.0 / 37.0, 1e-9);
  EXPECT_NEAR(site["glass"][0]["y_m"][1].get<double>(), -0.5, 1e-9);
  EXPECT_NEAR(site["free_never_driven_m2"].get<double>(), 35 * kSide * kCellM2, 1e-9);
}

TEST(SiteGrids, OfASiteWithoutFloorThereAreNoShares) {
  Room room;
  for (float& log_odds : room.map.log_odds.cells()) log_odds = 3.0F;
  for (CellTravel& cell : room.grids.travel.cells()) cell = {};
  const SiteFigures figures = figures_of(room.grids, room.map);
  const auto site = nlohmann::json::parse(format_summary({}, {}, {.site = &figures}))["site"];
  EXPECT_EQ(site["free_never_driven_share"], 0.0);
  EXPECT_TRUE(site["speed_m_s"].is_null());
}

TEST(SiteGrids, MasksHaveTheValuesOfTheirCells) {
  const Room room;
  const TempDir folder;
  write_site_grids(room.grids, figures_of(room.grids, room.map), Grid<float>(kFrame), room.map,
                   folder / "out", {2});
  struct Expected {
    const char* name;
    std::array<int, 5> values;  ///< unseen, wall, lane, where robots turned, seen long ago
  };
  const std::array<Cell, 5> cells{Cell{0, 5}, {2, 5}, {10, 5}, {11, 5}, {30, 5}};
  for (const auto& [name, values] :
       {Expected{"coverage", {255, 3, 3, 3, 1}}, Expected{"coverage_days", {255, 0, 0, 0, 10}},
        Expected{"travel", {255, 255, 100, 1, 0}}, Expected{"glass", {255, 98, 255, 255, 255}}}) {
    const std::string path = folder / "out/" + name;
    EXPECT_THAT(folder.read(std::string("out/") + name + ".yaml"),
                HasSubstr(std::string("image: ") + name + ".pgm"));
    EXPECT_THAT(folder.read(std::string("out/") + name + ".yaml"), HasSubstr("mode: raw"));
    const Image image = read_image(path + ".pgm");
    ASSERT_EQ(image.width, kSide);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const GridFrame flipped{.columns = kSide, .rows = kSide};
      EXPECT_EQ(image.bytes[flipped.index_of({cells[i].column, kSide - 1 - cells[i].row})],
                values[i])
          << name << " " << cells[i].column;
    }
  }
  for (const char* name : {"coverage.png", "travel.png", "glass.png", "movable.png"})
    EXPECT_GT(read_image(folder / "out/" + name).width, 100) << name;
}

TEST(SiteGrids, TheTableHasEachCellThatWasDriven) {
  const Room room;
  const TempDir folder;
  write_site_grids(room.grids, figures_of(room.grids, room.map), Grid<float>(kFrame), room.map,
                   folder / "out", {1});
  std::istringstream table(folder.read("out/travel.csv"));
  std::vector<std::string> lines;
  for (std::string line; std::getline(table, line);) lines.push_back(line);
  ASSERT_EQ(lines.size(), 1U + 2 * kSide);
  EXPECT_EQ(lines[0], "x_m,y_m,passes,speed_m_s");
  EXPECT_EQ(lines[1], "-0.475,-0.975,250,0.750");
  EXPECT_EQ(lines[2], "-0.425,-0.975,1,");
}

TEST(SiteGrids, PicturesShowWhatTheyMean) {
  const Room room;
  const SiteGround ground(room.map);
  const auto pixel_at = [&](const Image& image, Cell cell) {
    const Point at = ground.view.pixel_of(kFrame.centre_of(cell));
    const auto first = 3 * (static_cast<std::size_t>(at.y) * static_cast<std::size_t>(image.width) +
                            static_cast<std::size_t>(at.x));
    return std::array{image.bytes[first], image.bytes[first + 1], image.bytes[first + 2]};
  };
  const Image coverage = draw_coverage_picture(room.grids, room.map, ground);
  const auto seen = pixel_at(coverage, {15, 20});
  const auto unseen = pixel_at(coverage, {35, 20});
  EXPECT_GT(seen[2], seen[0]);      // blue
  EXPECT_GT(unseen[0], unseen[2]);  // amber
  const Image glass = draw_glass_picture(room.grids, ground);
  const auto pane = pixel_at(glass, {2, 5});
  const auto solid = pixel_at(glass, {2, 30});
  EXPECT_GT(pane[0], pane[2]);
  EXPECT_GT(solid[2], solid[0]);
  const Image travel = draw_travel_picture(room.grids, figures_of(room.grids, room.map), ground);
  EXPECT_NE(pixel_at(travel, {10, 20}), pixel_at(travel, {11, 20}));
  EXPECT_NE(pixel_at(travel, {10, 20}), pixel_at(travel, {20, 20}));
}

TEST(SiteGrids, OneSessionIsEnough) {
  Room room;
  for (std::uint16_t& visits : room.grids.coverage.visits.cells()) visits = visits > 0 ? 1 : 0;
  room.grids.coverage.newest = room.grids.coverage.visits;
  room.grids.coverage.begins.resize(1);
  const SiteGround ground(room.map);
  EXPECT_GT(draw_coverage_picture(room.grids, room.map, ground).width, 100);
  EXPECT_NEAR(figures_of(room.grids, room.map).floor.free_seen_by_newest_m2,
              figures_of(room.grids, room.map).floor.free_m2, 1e-12);
}

}  // namespace
}  // namespace loopstone
