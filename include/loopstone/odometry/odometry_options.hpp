#pragma once

#include "loopstone/base/options.hpp"

namespace loopstone {

/// Where the heading comes from.
enum class YawSource {
  kGyro,  ///< where it is silent, the wheels
  kWheels,
};

constexpr auto words_of(YawSource /*any*/) {
  using enum YawSource;
  return std::array{Word{kGyro, "gyro"}, Word{kWheels, "wheels"}};
}

/// How a step of the wheels becomes a motion.
enum class StepShape {
  kArc,    ///< exact
  kEuler,  ///< straight along the old heading, as in textbooks
};

constexpr auto words_of(StepShape /*any*/) {
  using enum StepShape;
  return std::array{Word{kArc, "arc"}, Word{kEuler, "euler"}};
}

/// How readings with different stamps are brought together.
enum class StampAlignment { kInterpolate, kNearest };

constexpr auto words_of(StampAlignment /*any*/) {
  using enum StampAlignment;
  return std::array{Word{kInterpolate, "interpolate"}, Word{kNearest, "nearest"}};
}

/// How wheel and gyro readings become a pose.
struct OdometryOptions {
  YawSource yaw = YawSource::kGyro;
  StepShape integration = StepShape::kArc;
  StampAlignment alignment = StampAlignment::kInterpolate;
  bool use_standstill = true;
  double max_extrapolation_s = 0.2;
  double distance_noise = 0.03;
  double heading_noise_per_metre = 0.02;
  double heading_noise_per_radian = 0.1;
};

template <typename Visitor>
void visit_options(OdometryOptions& options, Visitor&& visit) {
  visit("yaw", options.yaw,
        "where the heading comes from; gyro falls back to wheels where it is silent");
  visit("integration", options.integration, "exact arcs, or straight steps as in textbooks");
  visit("alignment", options.alignment, "how readings with different stamps are brought together");
  visit("use_standstill", options.use_standstill,
        "while the wheels stand, learn the gyro's bias and hold the heading");
  visit("max_extrapolation_s", options.max_extrapolation_s, Range{0.0, 5.0},
        "how far beyond the newest reading a pose is given, at constant velocity");
  visit("distance_noise", options.distance_noise, Range{0.0, 10.0},
        "standard deviation of the position after one metre [m/sqrt(m)]");
  visit("heading_noise_per_metre", options.heading_noise_per_metre, Range{0.0, 10.0},
        "standard deviation of the heading after one metre [rad/sqrt(m)]; a tenth with a gyro");
  visit("heading_noise_per_radian", options.heading_noise_per_radian, Range{0.0, 10.0},
        "standard deviation of the heading after turning by one radian [rad/sqrt(rad)]; a tenth "
        "with a gyro");
}

}  // namespace loopstone
