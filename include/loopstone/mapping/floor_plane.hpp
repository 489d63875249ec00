#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "loopstone/base/words.hpp"
#include "loopstone/geometry/pose3.hpp"
#include "loopstone/sensor/camera_model.hpp"
#include "loopstone/sensor/rgbd_images.hpp"

namespace loopstone {

/// The floor as a depth camera sees it: the ray (x, y, 1) of the optical frame meets it at 1 /
/// depth = slope . (x, y, 1). In inverse depth a plane is linear, and for cameras that triangulate
/// the noise is the same everywhere, so the least squares fit is the best one. Source: Konolige and
/// Mihelich 2012, "Technical description of Kinect calibration".
struct FloorPlane {
  Eigen::Vector3d slope = Eigen::Vector3d::Zero();  ///< [1/m]

  [[nodiscard]] double height_m() const { return 1.0 / slope.norm(); }  ///< of the camera above it
};

/// The floor (z = 0 of the robot's frame) for a camera that is mounted so.
[[nodiscard]] FloorPlane floor_plane_of(const Pose3& robot_T_camera);

/// The mount under which this plane is the robot's floor: roll, pitch and height follow from the
/// plane; x, y and yaw, of which a floor tells nothing, are those of `robot_T_camera`.
[[nodiscard]] Pose3 mount_seeing(const FloorPlane& plane, const Pose3& robot_T_camera);

enum class FloorStatus {
  kEstimated,
  kNotSeen,  ///< too little floor in the pictures; the given mount is kept
  kByFrame,  ///< the camera moves on the robot: each frame's floor tells its own mount
};

constexpr auto words_of(FloorStatus /*any*/) {
  using enum FloorStatus;
  return std::array{Word{kEstimated, "estimated"}, Word{kNotSeen, "not_seen"},
                    Word{kByFrame, "by_frame"}};
}

/// Where the camera really sits above the floor.
struct FloorEstimate {
  FloorStatus status = FloorStatus::kNotSeen;
  Pose3 robot_T_camera{};       ///< corrected
  FloorPlane plane{};           ///< under the corrected mount
  double roll_error_rad = 0.0;  ///< corrected less given
  double pitch_error_rad = 0.0;
  double height_error_m = 0.0;
  double pitch_scatter_rad =
      0.0;                   ///< of single frames about the estimate, robust standard deviation
  double noise_per_m = 0.0;  ///< of one inverse depth, robust standard deviation [1/m]
  std::int64_t points = 0;   ///< measurements that lie on the floor
  int frames = 0;            ///< in which the floor was seen
};

/// Fits the floor to what the camera measured in several frames. Points count that lie near the
/// floor of the given mount (within 0.08 m and 4 deg) and then near the fit (3 standard
/// deviations), so walls and things do not bend it.
///
///   FloorPlaneEstimator floor(camera);
///   for (const InverseDepthImage& depth : some_frames) floor.add(depth);
///   const FloorEstimate estimate = floor.estimate();
class FloorPlaneEstimator {
 public:
  explicit FloorPlaneEstimator(const CameraModel& camera);

  /// Memory: 12 bytes for each measurement kept, every fourth in both directions.
  void add(const InverseDepthImage& depth);
  /// Deterministic; independent of the order of the frames up to rounding.
  [[nodiscard]] FloorEstimate estimate() const;

 private:
  /// A measurement: the ray and what it measured.
  struct Sample {
    float x = 0.0F;
    float y = 0.0F;
    float per_m = 0.0F;
  };

  CameraModel camera_;
  FloorPlane given_;
  std::vector<Eigen::Vector2f> rays_{};  ///< of the pixels that are looked at, row-major
  std::vector<Sample> samples_{};
  std::vector<std::size_t> frame_starts_{};  ///< in samples_
};

}  // namespace loopstone
