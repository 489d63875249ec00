#include "loopstone/localization/localization_map.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "drawn_room.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

using test::drawn_solid;

Grid<std::int8_t> map_of_percent(std::int8_t percent) {
  return Grid<std::int8_t>(GridFrame{.columns = 8, .rows = 8}, percent);
}

/// What the map is refused for; empty: it isn't.
std::string refusal(Grid<std::int8_t> map) {
  try {
    const LocalizationMap made(std::move(map));
  } catch (const UsageError& error) {
    return error.what();
  }
  return {};
}

TEST(LocalizationMap, WithoutWallsOrFreeSpaceIsRefusedWithAReason) {
  EXPECT_NE(refusal(map_of_percent(0)).find("no wall"), std::string::npos);
  EXPECT_NE(refusal(map_of_percent(-1)).find("no wall"), std::string::npos);
  EXPECT_NE(refusal(map_of_percent(64)).find("no wall"), std::string::npos);
  EXPECT_NE(refusal(map_of_percent(65)).find("nothing free"), std::string::npos);
  EXPECT_NE(refusal(map_of_percent(100)).find("nothing free"), std::string::npos);
  EXPECT_NE(refusal(Grid<std::int8_t>{}).find("no wall"), std::string::npos);
  Grid<std::int8_t> unknown = map_of_percent(-1);
  unknown[{3, 3}] = 100;
  EXPECT_NE(refusal(unknown).find("nothing free"), std::string::npos);
  unknown[{4, 3}] = 0;
  EXPECT_EQ(refusal(unknown), "");
}

TEST(LocalizationMap, TellsFreeAreaAndMemory) {
  const Grid<std::int8_t> room = drawn_solid({0.0, 0.0}, {4.0, 3.0});
  const LocalizationMap map(room);
  EXPECT_NEAR(map.free_area_m2(), 12.0, 1e-9);
  EXPECT_GT(map.memory_bytes(), 4 * room.cells().size());
  EXPECT_EQ(map.occupancy().cells(), room.cells());
  EXPECT_EQ(map.occupancy().frame(), room.frame());
}

TEST(LocalizationMap, MayBeMoved) {
  LocalizationMap map(drawn_solid({0.0, 0.0}, {4.0, 3.0}));
  const LocalizationMap moved = std::move(map);
  EXPECT_NEAR(moved.free_area_m2(), 12.0, 1e-9);
}

}  // namespace
}  // namespace loopstone
