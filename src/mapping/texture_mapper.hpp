#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/geometry/pose3.hpp"
#include "loopstone/grid/grid_frame.hpp"
#include "loopstone/grid/tile_grid.hpp"
#include "loopstone/mapping/floor_texture.hpp"
#include "mapping/floor_lenses.hpp"
#include "mapping/floor_sight.hpp"
#include "mapping/frame_pose.hpp"
#include "mapping/light_rows.hpp"
#include "mapping/texture_cell.hpp"

namespace loopstone {

/// Gathers the colours of floor cells, frame by frame.
class TextureMapper {
 public:
  /// \param camera  as it is really mounted; `floor` belongs to it
  TextureMapper(const CameraModel& camera, const FloorEstimate& floor,
                const TextureOptions& options);

  /// From here on frames are those of a camera that sits elsewhere.
  void look_from(const CameraModel& camera, const FloorEstimate& floor);

  enum class Use { kUsed, kTilted };
  /// Frames come in a fixed order: colours are levelled against what is there.
  Use add(const RgbdImages& images, const FramePose& pose);

  [[nodiscard]] const TileGrid<TextureCell>& cells() const { return cells_; }
  /// Brightness of the frames against the cells, which have the first frame's: its mean, and its
  /// standard deviation as share.
  struct Brightness {
    double mean = 1.0;
    double spread = 0.0;
  };
  [[nodiscard]] Brightness brightness() const;

 private:
  struct Sample {
    TextureCell* cell = nullptr;
    LinearRgb light{};
    float weight = 0.0F;
  };
  /// Of the colour picture: where floor may be used, and how it lies on the floor around the robot.
  struct Footprint {
    std::vector<Eigen::Vector2d> corners_robot{};  ///< convex, in order
    int first_row = 0;
    int end_row = 0;
  };

  /// A frame's pose, made ready for looking at cells.
  struct View {
    Eigen::Matrix3d colour;    ///< floor_homography of the colour camera
    Eigen::Matrix3f colour_f;  ///< the same
    Eigen::Matrix3d depth;     ///< of the depth camera
    float moved_m = 0.0F;      ///< while the shutter was open
    float turned_rad = 0.0F;
  };
  /// A cell as a frame sees it.
  struct Glimpse {
    FloorBox box{};
    float blur2_m2 = 0.0F;  ///< squared length over which pixel and motion smear the floor
  };
  /// Cells of a row, first and last included.
  struct CellRun {
    int row = 0;
    int first_column = 0;
    int last_column = 0;
  };

  [[nodiscard]] Footprint make_footprint() const;
  [[nodiscard]] View view_from(const FramePose& pose) const;
  [[nodiscard]] std::vector<CellRun> runs_seen_from(const Pose2& map_T_robot) const;
  /// False when the frame does not see the cell, or not sharply enough, or something stands there.
  [[nodiscard]] bool look(Cell cell, const View& view, Glimpse& glimpse) const;
  [[nodiscard]] float weight_of(const Glimpse& glimpse) const;
  /// The pose at which the frame agrees best with the cells known so far; the given one when there
  /// are too few, or when it would have to move by more than a good trajectory is wrong.
  [[nodiscard]] FramePose refined(const FramePose& given) const;
  struct StepSums;
  /// How a frame at that pose agrees with the map, for the next step of refined().
  /// \param gain   of the frame against the map
  /// \param sigma  beyond which a difference counts little
  [[nodiscard]] StepSums compare(const FramePose& pose, const std::vector<CellRun>& runs,
                                 double gain, double sigma) const;
  void sample_cells(const FramePose& pose);
  void level_samples();

  CameraModel camera_;
  TextureOptions options_;
  Pose3 robot_T_colour_;
  Pose3 robot_T_depth_;
  Footprint footprint_;
  float blur_per_depth2_;  ///< a pixel's length along the view on the floor, over depth^2 [1/m]
  float width_per_depth_;  ///< a pixel's width there, over depth
  float most_blur2_m2_;
  FloorLenses lenses_;
  FloorSight sight_;
  LightRows light_;
  TileGrid<TextureCell> cells_;
  std::vector<Sample> samples_{};
  std::array<std::vector<float>, 4> ratios_{};  ///< of red, green, blue, and their sum
  std::int64_t frames_levelled_ = 0;
  double log_gain_sum_ = 0.0;
  double log_gain_sum2_ = 0.0;
};

}  // namespace loopstone
