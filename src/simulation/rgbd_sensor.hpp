#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/simulation/camera_renderer.hpp"
#include "loopstone/simulation/drive.hpp"
#include "loopstone/simulation/simulated_camera.hpp"
#include "simulation/people.hpp"

namespace loopstone {

/// Normal numbers fast: one of 4096 quantiles, five from each 64 random bits. Standard deviation 1
/// within 0.1 %; none beyond 3.7.
class QuickNormals {
 public:
  explicit QuickNormals(Rng rng);
  [[nodiscard]] float next() {
    if (left_ == 0) {
      bits_ = rng_();
      left_ = 5;
    }
    --left_;
    const float normal = (*quantiles_)[bits_ & 4095U];
    bits_ >>= 12U;
    return normal;
  }

 private:
  using Quantiles = std::array<float, 4096>;
  static const Quantiles& quantiles();

  Rng rng_;
  const Quantiles* quantiles_;
  std::uint64_t bits_ = 0;
  int left_ = 0;
};

/// The pictures that an RGB-D camera takes of a world during a drive.
class RgbdSensor {
 public:
  /// \param camera  as it truly is
  RgbdSensor(const World& world, const Drive& drive, const SurfaceIndex& surfaces,
             const Crowd& crowd, const CameraModel& camera, const SimulatedCamera& options,
             Rng rng);

  [[nodiscard]] RawDepthImage depth_at(double time_s);
  [[nodiscard]] ColourImage colour_at(double time_s);

 private:
  const Drive& drive_;
  const Crowd& crowd_;
  DepthEncoding encoding_;
  double depth_focal_px_;
  SimulatedCamera options_;
  CameraRenderer renderer_;
  Rng depth_rng_;
  Rng colour_rng_;
  Rng gain_rng_;
  double log_gain_ = 0.0;
  bool has_gain_ = false;
  std::vector<float> inverse_depths_;  ///< of every number
  std::vector<float> levels_;          ///< 0 to 255 of linear light in even steps
  std::vector<float> brightness_;      ///< of every pixel, by vignetting
};

}  // namespace loopstone
