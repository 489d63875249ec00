#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "loopstone/base/options.hpp"
#include "loopstone/base/parallel_for.hpp"
#include "loopstone/base/progress.hpp"
#include "loopstone/grid/grid_frame.hpp"
#include "loopstone/grid/tile_grid.hpp"
#include "loopstone/mapping/camera_clock.hpp"
#include "loopstone/mapping/coloured_point.hpp"
#include "loopstone/mapping/floor_plane.hpp"
#include "loopstone/mapping/rgbd_source.hpp"
#include "loopstone/odometry/trajectory.hpp"
#include "loopstone/sensor/camera_model.hpp"

namespace loopstone {

/// How the colour of the floor is put on the map.
struct TextureOptions {
  double resolution_m = 0.01;
  double max_blur_m = 0.015;
  double height_tolerance_m = 0.01;
  double min_travel_m = 0.02;
  double min_turn_rad = 0.01;
  double exposure_s = 0.01;
  double fill_gap_m = 0.03;
  double cloud_cube_m = 0.0;
  bool correct_mount = true;
  bool correct_clock = true;
  bool level_exposure = true;
  bool refine_poses = true;
};

template <typename Visitor>
void visit_options(TextureOptions& options, Visitor&& visit) {
  visit("resolution_m", options.resolution_m, Range{0.001, 0.5}, "side of a cell of the texture");
  visit("max_blur_m", options.max_blur_m, Range{0.001, 1.0},
        "floor that a pixel and the motion smear over more is not used");
  visit("height_tolerance_m", options.height_tolerance_m, Range{0.001, 0.5},
        "what is nearer to the floor's plane is floor, beyond the camera's noise");
  visit("min_travel_m", options.min_travel_m, Range{0.0, 10.0},
        "a frame is used after so much travel");
  visit("min_turn_rad", options.min_turn_rad, Range{0.0, 3.2}, "or after so much turning");
  visit("exposure_s", options.exposure_s, Range{0.0, 0.2},
        "how long the shutter is open: motion smears so long");
  visit("fill_gap_m", options.fill_gap_m, Range{0.0, 1.0},
        "unseen cells between seen ones this near are filled from them");
  visit("cloud_cube_m", options.cloud_cube_m, Range{0.0, 1.0},
        "side of the cubes in which all points seen are gathered in colour; 0: none are");
  visit("correct_mount", options.correct_mount,
        "estimate roll, pitch and height of the camera from the floor");
  visit("correct_clock", options.correct_clock,
        "estimate how late the camera's stamps are from its motion over the floor");
  visit("level_exposure", options.level_exposure, "level the brightness of the frames");
  visit("refine_poses", options.refine_poses,
        "move each frame by the few millimetres that make it agree with the floor seen before");
}

/// A cell of the finished texture: sRGB and what it rests on.
struct TextureColour {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
  std::uint8_t coverage = 0;  ///< kSeen, kFilled, or 0: nothing is known

  static constexpr std::uint8_t kSeen = 255;
  static constexpr std::uint8_t kFilled = 128;  ///< not seen; from the seen cells on both sides
  friend bool operator==(const TextureColour&, const TextureColour&) = default;
};

/// What became of a recording's frames.
struct TextureStatistics {
  std::int64_t frames = 0;  ///< with depth and colour
  std::int64_t frames_used = 0;
  std::int64_t frames_still = 0;         ///< too near to the one before
  std::int64_t frames_without_pose = 0;  ///< outside the trajectory's time
  std::int64_t frames_tilted = 0;        ///< the floor was not where it should be
  std::int64_t frames_unreadable = 0;
  double seen_area_m2 = 0.0;
  double filled_area_m2 = 0.0;
  double gain_spread = 0.0;       ///< standard deviation of the frames' brightness, share
  std::int64_t memory_bytes = 0;  ///< of the cells at most
};

/// The colour of the floor.
struct FloorTexture {
  TileGrid<TextureColour> cells{};
  GridFrame frame{};  ///< covers all cells that are known; its cell (0, 0) is cells' first_cell
  Cell first_cell{};
  std::vector<ColouredPoint> cloud{};  ///< everything seen, when asked for
  FloorEstimate floor{};
  CameraClock clock{};
  TextureStatistics statistics{};
  std::vector<std::string> warnings{};  ///< in plain words
  bool complete = true;                 ///< false when progress asked to stop

  /// The colour of a cell of `frame`; coverage 0 where nothing is known.
  [[nodiscard]] TextureColour at(Cell cell) const {
    const TextureColour* found =
        cells.find({cell.column + first_cell.column, cell.row + first_cell.row});
    return found == nullptr ? TextureColour{} : *found;
  }
};

/// Puts the colours of the floor on the map, in these steps:
///   1. the floor's plane in some frames tells how the camera is really mounted
///      (FloorPlaneEstimator),
///   2. how the floor moves through the picture tells how late the camera's stamps are
///      (estimate_camera_clock),
///   3. each frame that adds something gives a colour to every cell that it sees: the mean light
///      over the cell's outline in the picture, if the depth picture measured floor there; weighted
///      by blur, levelled in brightness, joined robustly (TextureCell); before that the frame moves
///      by the few millimetres that make it agree with the floor seen before,
///   4. small gaps between seen cells are filled,
///   5. if asked for, every point that the depth camera measured gets its colour as well (`cloud`).
/// The robot's pose at each picture's own stamp is interpolated on the trajectory.
///
/// \param source      frames in time order; loaded when needed, at most a few at a time
/// \param trajectory  map_T_robot
/// Deterministic: the same bytes for any number of threads. Cost: about 4 ms a frame of 640 x 480
/// beside loading it.
/// Memory: 16 bytes a cell that was seen, plus 4.
[[nodiscard]] FloorTexture map_floor_texture(const RgbdSource& source, const Trajectory& trajectory,
                                             const CameraModel& camera,
                                             const TextureOptions& options = {},
                                             Threads threads = {},
                                             const ProgressCallback& progress = {});

}  // namespace loopstone
