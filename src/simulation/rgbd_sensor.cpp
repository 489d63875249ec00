#include "simulation/rgbd_sensor.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "loopstone/base/error_function.hpp"
#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/base/linear_light.hpp"
#include "loopstone/sensor/camera_geometry.hpp"

namespace loopstone {
namespace {

constexpr std::size_t kLightSteps = 1U << 14U;
constexpr double kGrazing =
    0.1;  ///< cosine below which depth begins to fail: the floor 3.6 m ahead of a Kinect at 0.36 m
constexpr double kGainMemory_s = 3.0;  ///< how long the automatic exposure stays about the same

/// A step of the Kinect's disparity as inverse depth [1/m].
constexpr float kKinectStep_per_m = 0.00304F / 1.03F;

/// The number x at which a standard normal's distribution reaches p, by bisection.
double normal_quantile(double p) {
  double low = -8.0;
  double high = 8.0;
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (low + high);
    (0.5 * complementary_error_function(-middle / std::sqrt(2.0)) < p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// The number that stands for an inverse depth, before rounding.
float number_of(const DepthEncoding& encoding, float inverse_per_m) {
  if (encoding.kind == DepthKind::kDepth) {
    return 1.0F / (inverse_per_m * static_cast<float>(encoding.metres_per_unit));
  }
  return (inverse_per_m * static_cast<float>(encoding.disparity_numerator_m) -
          static_cast<float>(encoding.disparity_offset)) /
         static_cast<float>(encoding.disparity_slope);
}

std::vector<float> brightness_of(const LensModel& lens, double vignetting) {
  std::vector<float> brightness;
  const double corner = hypotenuse(lens.width_px, lens.height_px) / 2.0;
  for (int row = 0; row < lens.height_px; ++row) {
    for (int column = 0; column < lens.width_px; ++column) {
      const double radius = hypotenuse(column - lens.centre_x_px, row - lens.centre_y_px) / corner;
      brightness.push_back(static_cast<float>(std::max(0.0, 1.0 - vignetting * radius * radius)));
    }
  }
  return brightness;
}

}  // namespace

QuickNormals::QuickNormals(Rng rng) : rng_(rng), quantiles_(&quantiles()) {}

const QuickNormals::Quantiles& QuickNormals::quantiles() {
  static const Quantiles table = [] {
    Quantiles values{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = static_cast<float>(
          normal_quantile((static_cast<double>(i) + 0.5) / static_cast<double>(values.size())));
    }
    return values;
  }();
  return table;
}

RgbdSensor::RgbdSensor(const World& world, const Drive& drive, const SurfaceIndex& surfaces,
                       const Crowd& crowd, const CameraModel& camera,
                       const SimulatedCamera& options, Rng rng)
    : drive_(drive),
      crowd_(crowd),
      encoding_(camera.encoding),
      depth_focal_px_(camera.depth.focal_x_px),
      options_(options),
      renderer_(world, surfaces, camera),
      depth_rng_(rng.fork(1)),
      colour_rng_(rng.fork(2)),
      gain_rng_(rng.fork(3)),
      inverse_depths_(inverse_depth_table(camera.encoding)),
      brightness_(brightness_of(colour_lens(camera), options.colour.vignetting)) {
  levels_.reserve(kLightSteps);
  for (std::size_t i = 0; i < kLightSteps; ++i) {
    levels_.push_back(
        static_cast<float>(255.0 * srgb_of_linear(static_cast<double>(i) / (kLightSteps - 1))));
  }
}

RawDepthImage RgbdSensor::depth_at(double time_s) {
  const TrueDepth seen = renderer_.depth(drive_.pose_at(time_s), crowd_.legs_at(time_s));
  RawDepthImage image{seen.depth.width, seen.depth.height, {}};
  image.numbers.assign(seen.depth.per_m.size(), 0);
  QuickNormals normals(depth_rng_.fork(0));
  Rng chance = depth_rng_.fork(1);
  depth_rng_ = depth_rng_.fork(2);
  const auto noise = static_cast<float>(options_.depth.noise_steps) * kKinectStep_per_m;
  const auto shift = static_cast<float>(options_.depth.projector_baseline_m * depth_focal_px_);
  for (int row = 0; row < image.height; ++row) {
    // The projector sits to the right of the camera and sees a point of inverse depth q in its
    // column u - shift q. What has another point before it there lies in the shadow; coming from
    // the right, columns that are not new have one.
    float lit_from = std::numeric_limits<float>::infinity();
    for (int column = image.width - 1; column >= 0; --column) {
      const std::size_t i = static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) +
                            static_cast<std::size_t>(column);
      const float inverse = seen.depth.per_m[i];
      // The same draws for every pixel, whatever it sees.
      const float error = noise * normals.next();
      const double draw = chance.uniform();
      if (inverse <= 0.0F) continue;
      const float projected = static_cast<float>(column) - shift * inverse;
      const bool is_lit = projected < lit_from;
      lit_from = std::min(lit_from, projected);
      const double grazing = std::max(0.0, 1.0 - static_cast<double>(seen.facing[i]) / kGrazing) *
                             options_.depth.grazing_dropout;
      const double lost = 1.0 - (1.0 - options_.depth.dropout_probability) * (1.0 - grazing);
      if (!is_lit || draw < lost || inverse + error <= 0.0F) continue;
      const float number = std::round(number_of(encoding_, inverse + error));
      if (!(number >= 1.0F && number <= 65535.0F)) continue;
      const auto raw = static_cast<std::uint16_t>(number);
      if (inverse_depths_[raw] > 0.0F) image.numbers[i] = raw;
    }
  }
  return image;
}

ColourImage RgbdSensor::colour_at(double time_s) {
  const double half = 0.5 * options_.colour.exposure_s;
  const ExposedPose pose{drive_.pose_at(time_s),
                         drive_.travelled_m(time_s + half) - drive_.travelled_m(time_s - half),
                         drive_.turned_rad(time_s + half) - drive_.turned_rad(time_s - half)};
  const LightImage seen = renderer_.light(pose, crowd_.legs_at(time_s));
  // A mean-reverting random walk; its first value is already as uncertain as the later ones.
  const double keep = has_gain_ ? std::exp(-1.0 / (options_.rate_hz * kGainMemory_s)) : 0.0;
  log_gain_ = keep * log_gain_ + std::sqrt(1.0 - keep * keep) * options_.colour.gain_wander *
                                     gain_rng_.normal(0.0, 1.0);
  has_gain_ = true;

  ColourImage image{seen.width, seen.height, {}};
  image.rgb.resize(3 * seen.pixels.size());
  QuickNormals normals(colour_rng_.fork(0));
  colour_rng_ = colour_rng_.fork(1);
  const auto gain = static_cast<float>(std::exp(log_gain_) * (kLightSteps - 1));
  const auto noise = static_cast<float>(options_.colour.noise_levels);
  constexpr auto kLast = static_cast<float>(kLightSteps - 1);
  for (std::size_t i = 0; i < seen.pixels.size(); ++i) {
    for (int channel = 0; channel < 3; ++channel) {
      const float light = std::min(gain * brightness_[i] * seen.pixels[i][channel], kLast);
      const float level = levels_[static_cast<std::size_t>(light + 0.5F)] + noise * normals.next();
      image.rgb[3 * i + static_cast<std::size_t>(channel)] =
          static_cast<std::uint8_t>(std::clamp(level + 0.5F, 0.0F, 255.0F));
    }
  }
  return image;
}

}  // namespace loopstone
