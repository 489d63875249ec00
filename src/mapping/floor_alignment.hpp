#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/geometry/pose3.hpp"
#include "loopstone/mapping/floor_plane.hpp"
#include "loopstone/sensor/camera_model.hpp"
#include "loopstone/sensor/rgbd_images.hpp"
#include "mapping/floor_lenses.hpp"
#include "mapping/floor_sight.hpp"
#include "mapping/light_rows.hpp"

namespace loopstone {

/// How the robot moved between two pictures, by the floor that both see.
struct FloorMotion {
  Pose2 from_T_to{};
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of x, y, yaw: from the residuals
  double correlation = 0.0;                              ///< of the two pictures there, -1 to 1
};

/// A picture of the floor as the robot would see it from above: brightness on a grid before the
/// robot.
class FloorAligner {
 public:
  /// \param camera  as it is really mounted
  FloorAligner(const CameraModel& camera, const FloorPlane& plane, double noise_per_m);

  /// Nothing when the pictures share too little floor, or floor without structure, or no guess
  /// leads to agreement. Gauss-Newton over the pose and the change of brightness and contrast,
  /// coarse (5 cm) to fine (2 cm), inverse compositional: Baker and Matthews 2004, "Lucas-Kanade 20
  /// years on", section 3.2.
  /// \param guesses  of from_T_to; the one that agrees best is refined
  [[nodiscard]] std::optional<FloorMotion> align(const RgbdImages& from, const RgbdImages& to,
                                                 std::span<const Pose2> guesses);

 private:
  /// A frame made ready.
  struct View {
    LightRows light{};
    FloorSight sight;
  };
  struct Template {
    std::vector<Eigen::Vector2f> points_m{};  ///< robot frame
    std::vector<float> brightness{};
    std::vector<Eigen::Vector2f> slope_per_m{};
  };
  struct Fit;

  void assign(View& view, const RgbdImages& images) const;
  /// Brightness (square root of light, 0 to 256) of a square of floor; negative where it can't be
  /// seen.
  [[nodiscard]] float brightness(const View& view, const Eigen::Vector2f& point_m,
                                 float side_m) const;
  [[nodiscard]] Template make_template(const View& view, float side_m, int every) const;
  [[nodiscard]] Fit measure(const Template& reference, const View& view, const Pose2& from_T_to,
                            float side_m) const;

  FloorLenses lenses_;
  Eigen::Matrix3f colour_homography_;
  Eigen::Matrix3f depth_homography_;
  std::vector<Eigen::Vector2f> grid_m_{};  ///< points of the floor that the colour camera sees
  int first_row_ = 0;
  View from_;
  View to_;
};

}  // namespace loopstone
