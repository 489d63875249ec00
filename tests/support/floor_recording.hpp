#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "loopstone/base/linear_light.hpp"
#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/mapping/floor_texture.hpp"
#include "loopstone/mapping/rgbd_source.hpp"
#include "loopstone/odometry/trajectory.hpp"
#include "support/rendered_floor.hpp"

namespace loopstone::test {

inline Stamp at_s(double seconds) { return Stamp::from_seconds(seconds); }

/// Frames along a drive, rendered when they are loaded; a frame's paths hold nothing but their
/// being there.
struct Recording {
  FloorScene scene{wavy_floor};
  CameraModel truth = small_camera();
  Trajectory trajectory{};
  double late_s = 0.0;          ///< of the camera's stamps
  double colour_delay_s = 0.0;  ///< colour is taken so much after depth
  std::function<double(Stamp)> gain{};

  [[nodiscard]] RgbdSource source(double rate_hz) const {
    RgbdSource made;
    const double end_s = trajectory.back().stamp.seconds();
    for (double t = trajectory.front().stamp.seconds(); t + colour_delay_s < end_s;
         t += 1.0 / rate_hz) {
      made.frames.push_back({at_s(t + late_s), at_s(t + colour_delay_s + late_s), "c", "d"});
    }
    // The cache is filled by one thread at a time; the same frame is asked for by several steps.
    auto cache = std::make_shared<std::map<std::pair<Stamp, Stamp>, RgbdImages>>();
    auto lock = std::make_shared<std::mutex>();
    made.load = [this, cache, lock](const RgbdFrame& frame) {
      const std::lock_guard guard(*lock);
      RgbdImages& known = (*cache)[{frame.stamp, frame.colour_stamp}];
      if (!known.depth.empty()) return known;
      const Duration late = Duration::from_seconds(late_s);
      RgbdImages images = render(scene, truth, *trajectory.at_clamped(frame.stamp - late),
                                 *trajectory.at_clamped(frame.colour_stamp - late), 2, true);
      images.depth_stamp = frame.stamp;
      images.colour_stamp = frame.colour_stamp;
      if (gain) {
        for (std::uint8_t& value : images.colour.rgb) {
          const double light = linear_of_srgb(value / 255.0) * gain(frame.stamp);
          value =
              static_cast<std::uint8_t>(std::lround(255.0 * srgb_of_linear(std::min(1.0, light))));
        }
      }
      known = images;
      return images;
    };
    return made;
  }
};

/// Turns that come and go over a forward drive.
inline Trajectory winding(double duration_s, double turning = 0.6) {
  Trajectory trajectory;
  Pose2 pose{0.3, -0.2, 0.4};
  constexpr double kStep_s = 0.01;
  for (double t = 100.0; t < 100.0 + duration_s; t += kStep_s) {
    trajectory.append(at_s(t), pose);
    pose = pose * exp(Tangent2{0.3 * kStep_s, 0.0, turning * std::sin(2.5 * t) * kStep_s});
  }
  return trajectory;
}

/// For a quarter of the usual pixels.
inline TextureOptions coarse() {
  TextureOptions options;
  options.resolution_m = 0.02;
  options.max_blur_m = 0.05;
  options.exposure_s = 0.0;
  options.fill_gap_m = 0.06;
  return options;
}

/// Error of the seen cells against the mean of the true floor over each cell.
struct Score {
  double psnr_db = 0.0;
  std::int64_t cells = 0;
};
inline Score score(const FloorTexture& texture, const FloorColour& truth) {
  Score result;
  double squares = 0.0;
  for (int row = 0; row < texture.frame.rows; ++row) {
    for (int column = 0; column < texture.frame.columns; ++column) {
      const TextureColour found = texture.at({column, row});
      if (found.coverage != TextureColour::kSeen) continue;
      const Eigen::Vector2d centre = texture.frame.centre_of({column, row});
      Eigen::Vector3d light = Eigen::Vector3d::Zero();
      constexpr int kSamples = 4;
      for (int i = 0; i < kSamples * kSamples; ++i) {
        const double dx = ((i % kSamples + 0.5) / kSamples - 0.5) * texture.frame.resolution;
        const double dy = ((i / kSamples + 0.5) / kSamples - 0.5) * texture.frame.resolution;
        light += truth(centre.x() + dx, centre.y() + dy);
      }
      light /= kSamples * kSamples;
      const std::array<int, 3> rgb{found.red, found.green, found.blue};
      for (int c = 0; c < 3; ++c) {
        const double error = rgb[static_cast<std::size_t>(c)] - 255.0 * srgb_of_linear(light[c]);
        squares += error * error / 3.0;
      }
      ++result.cells;
    }
  }
  result.psnr_db = 10.0 * std::log10(255.0 * 255.0 * static_cast<double>(result.cells) / squares);
  return result;
}

}  // namespace loopstone::test
