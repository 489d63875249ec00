#pragma once

#include <cstdint>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/mapping/floor_texture.hpp"
#include "loopstone/odometry/trajectory.hpp"
#include "loopstone/report/run_info.hpp"

namespace loopstone::test {

inline constexpr int kTextureColumns = 70;
inline constexpr int kTextureRows = 40;

/// Seen in the left half, a filled column, then nothing, and one lone cell in the upper right
/// corner.
inline TextureColour texture_scene_at(Cell cell) {
  const auto level = static_cast<std::uint8_t>(3 * cell.column);
  const auto other = static_cast<std::uint8_t>(5 * cell.row);
  if (cell == Cell{kTextureColumns - 1, kTextureRows - 1}) {
    return {1, 2, 3, TextureColour::kSeen};
  }
  if (cell.column < 35) return {level, other, 77, TextureColour::kSeen};
  if (cell.column == 35) return {level, other, 88, TextureColour::kFilled};
  return {};
}

inline FloorTexture texture_scene() {
  FloorTexture texture;
  texture.cells = TileGrid<TextureColour>(0.02);
  texture.first_cell = {-30, 85};
  texture.frame = {
      .origin = {-0.6, 1.7}, .resolution = 0.02, .columns = kTextureColumns, .rows = kTextureRows};
  for (int row = 0; row < kTextureRows; ++row) {
    for (int column = 0; column < kTextureColumns; ++column) {
      const TextureColour colour = texture_scene_at({column, row});
      if (colour.coverage == 0) continue;
      texture.cells.at({column + texture.first_cell.column, row + texture.first_cell.row}) = colour;
    }
  }
  texture.floor.status = FloorStatus::kEstimated;
  texture.floor.pitch_error_rad = radians(1.25);
  texture.floor.roll_error_rad = radians(-0.5);
  texture.floor.height_error_m = 0.004;
  texture.clock = {ClockStatus::kEstimated, 0.05, 0.002, 40};
  texture.statistics = {.frames = 120, .frames_used = 100, .frames_still = 15};
  texture.statistics.frames_without_pose = 2;
  texture.statistics.frames_unreadable = 3;
  texture.statistics.seen_area_m2 = 0.5604;
  texture.statistics.filled_area_m2 = 0.016;
  texture.warnings = {"the mount <differs>"};
  return texture;
}

inline Trajectory texture_path() {
  Trajectory path;
  for (int i = 0; i < 20; ++i) {
    path.append(Stamp{1500000000000000000 + i * 100000000LL},
                Pose2{-0.5 + 0.04 * i, 1.9 + 0.01 * i, 0.2});
  }
  return path;
}

inline RunInfo texture_info() {
  RunInfo info;
  info.log_path = "/logs/a&b";
  info.options_toml = "[texture]\nresolution_m = 0.02\n";
  info.version = "9.8.7";
  info.wall_time_s = 0.5;
  return info;
}

}  // namespace loopstone::test
