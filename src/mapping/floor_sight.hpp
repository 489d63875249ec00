#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "loopstone/grid/grid_frame.hpp"
#include "loopstone/mapping/floor_plane.hpp"
#include "loopstone/sensor/camera_model.hpp"
#include "loopstone/sensor/rgbd_images.hpp"

namespace loopstone {

/// Which pixels of a frame see the floor: in the depth picture those that measured it, in the
/// colour picture those before which nothing stands. The cameras look from two places, so what
/// hides the floor from one may not hide it from the other.
class FloorSight {
 public:
  /// \param height_tolerance_m  what is within this of the floor counts as floor, beyond three
  ///                            times the camera's noise
  FloorSight(const CameraModel& camera, const FloorPlane& plane, double noise_per_m,
             double height_tolerance_m);

  void assign(const InverseDepthImage& depth);

  /// Whether the floor was measured at this pixel of the depth picture, or right and left of a
  /// pixel without measurement.
  [[nodiscard]] bool measured(float column, float row) const {
    const auto u = floor_to_int(static_cast<double>(column) + 0.5);
    const auto v = floor_to_int(static_cast<double>(row) + 0.5);
    if (u < kReach || v < 0 || u >= width_ - kReach || v >= height_) return false;
    const std::uint8_t* at =
        &floor_[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
                static_cast<std::size_t>(u)];
    return *at == kFloor || (*at == kNothing && at[-kReach] == kFloor && at[kReach] == kFloor);
  }
  /// Whether something stands before the floor at this pixel of the colour picture, or close to it.
  [[nodiscard]] bool hidden(float column, float row) const {
    const int u = static_cast<int>(column) / kBlock;
    const int v = static_cast<int>(row) / kBlock;
    if (u < 0 || v < 0 || u >= block_columns_ || v >= block_rows_) return true;
    return blocks_[static_cast<std::size_t>(v) * static_cast<std::size_t>(block_columns_) +
                   static_cast<std::size_t>(u)] != 0;
  }
  /// By how much this frame's floor is tilted against the plane given; 0 when too little of it is
  /// seen.
  [[nodiscard]] double tilt_rad() const { return tilt_rad_; }

 private:
  static constexpr std::uint8_t kOther = 0;
  static constexpr std::uint8_t kFloor = 1;
  static constexpr std::uint8_t kNothing = 2;
  static constexpr int kReach = 3;  ///< pixels over which a hole is bridged
  static constexpr int kBlock =
      4;  ///< side of the blocks of the colour picture that are told apart

  void measure_tilt(const InverseDepthImage& depth);
  /// Whether nothing was measured around a pixel either.
  [[nodiscard]] bool is_void(int column, int row) const;
  void mark_obstacles(const InverseDepthImage& depth);

  int width_;
  int height_;
  float noise_gate_per_m_;
  float height_gate_;              ///< height tolerance as share of the camera's height
  std::vector<float> expected_{};  ///< 1 / depth of the floor for each pixel [1/m]
  std::vector<std::uint8_t> floor_{};

  /// Of every second pixel of every second row: the ray in the colour camera's axes.
  std::vector<Eigen::Vector3f> colour_rays_{};
  Eigen::Vector3f
      depth_in_colour_m_;  ///< the depth camera's place in the colour camera's optical frame
  float focal_x_px_;
  float focal_y_px_;
  float centre_x_px_;
  float centre_y_px_;
  float void_step_per_m_;  ///< steps in which what a hole may hide is tried [1/m]
  float most_per_m_;
  int block_columns_;
  int block_rows_;
  std::vector<std::uint8_t> marked_{};
  std::vector<std::uint8_t> blocks_{};
  std::vector<Eigen::Vector3f> tilt_rays_{};  ///< of every eighth pixel of every eighth row
  double plane_height_m_;
  double tilt_rad_ = 0.0;
};

}  // namespace loopstone
