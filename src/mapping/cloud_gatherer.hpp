#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "loopstone/geometry/pose3.hpp"
#include "loopstone/mapping/coloured_point.hpp"
#include "loopstone/sensor/camera_model.hpp"
#include "loopstone/sensor/rgbd_images.hpp"
#include "mapping/frame_pose.hpp"
#include "mapping/texture_cell.hpp"

namespace loopstone {

/// Gathers all that the depth camera measured, in cubes: the mean place and the prevailing colour
/// of each. Measurements whose noise along the view exceeds a cube, and those at the edges of
/// things, are left out.
class CloudGatherer {
 public:
  /// \param camera       as it is really mounted
  /// \param noise_per_m  of an inverse depth
  CloudGatherer(const CameraModel& camera, double noise_per_m, double cube_m);

  /// From here on frames are those of a camera that sits elsewhere, with the same lenses.
  void look_from(const Pose3& robot_T_camera);
  void add(const RgbdImages& images, const FramePose& pose);

  /// In the order of the cubes; cubes measured fewer than three times are left out.
  [[nodiscard]] std::vector<ColouredPoint> points() const;

 private:
  struct Cube {
    Eigen::Vector3f sum_m =
        Eigen::Vector3f::Zero();  ///< of the places, from the cube's lower corner
    std::uint32_t count = 0;
    TextureCell colour{};
  };

  CameraModel camera_;
  Pose3 robot_T_depth_;
  Pose3 robot_T_colour_;
  std::array<std::uint16_t, 256> light_;  ///< of sRGB values
  float cube_m_;
  float least_per_m_;
  std::vector<Eigen::Vector3f> rays_{};  ///< of the pixels that are looked at
  std::unordered_map<std::uint64_t, Cube> cubes_{};
};

}  // namespace loopstone
