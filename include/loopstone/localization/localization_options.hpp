#pragma once

#include "loopstone/base/options.hpp"
#include "loopstone/localization/motion_models.hpp"
#include "loopstone/localization/resampling.hpp"

namespace loopstone {

/// How particles are moved.
enum class ParticleMotion {
  kAuto,      ///< by odometry with its own covariance, gyro-aided where there is one
  kOdometry,  ///< sample_odometry_motion
  kVelocity,  ///< sample_velocity_motion
};

constexpr auto words_of(ParticleMotion /*any*/) {
  using enum ParticleMotion;
  return std::array{Word{kAuto, "auto"}, Word{kOdometry, "odometry"}, Word{kVelocity, "velocity"}};
}

/// What a scan weighs a particle by.
enum class ScanModel { kLikelihoodField, kBeamSkipping, kBeam };

constexpr auto words_of(ScanModel /*any*/) {
  using enum ScanModel;
  return std::array{Word{kLikelihoodField, "likelihood_field"},
                    Word{kBeamSkipping, "beam_skipping"}, Word{kBeam, "beam"}};
}

struct LocalizationOptions {
  int particles_max = 2000;
  int particles_min = 100;
  ParticleMotion motion = ParticleMotion::kAuto;
  ScanModel sensor = ScanModel::kLikelihoodField;
  ResamplingScheme resampling = ResamplingScheme::kSystematic;
  int beams = 90;
  double update_distance_m = 0.1;
  double update_angle_rad = 0.1;
  double tracking_probability = 0.9;
  double lost_probability = 0.1;
  bool recover = true;
  double snapshot_distance_m = 0.0;
  OdometryMotionNoise odometry_noise{};  ///< of ParticleMotion::kOdometry
  VelocityMotionNoise velocity_noise{};  ///< of ParticleMotion::kVelocity
};

template <typename Visitor>
void visit_options(LocalizationOptions& options, Visitor&& visit) {
  visit("particles_max", options.particles_max, Range{10, 1e6},
        "particles of all hypotheses together");
  visit("particles_min", options.particles_min, Range{10, 1e5}, "particles of each hypothesis");
  visit("motion", options.motion,
        "auto: odometry's own covariance, gyro-aided; or the models of Thrun, tables 5.6 and 5.3");
  visit("sensor", options.sensor, "how a scan weighs a particle");
  visit("resampling", options.resampling, "how particles are drawn anew");
  visit("beams", options.beams, Range{10, 2000}, "beams of a scan that weigh particles");
  visit("update_distance_m", options.update_distance_m, Range{0.0, 5.0},
        "particles are weighed after so much travel");
  visit("update_angle_rad", options.update_angle_rad, Range{0.0, 3.2}, "or after so much turning");
  visit("tracking_probability", options.tracking_probability, Range{0.5, 1.0},
        "from here up the state is TRACKING");
  visit("lost_probability", options.lost_probability, Range{0.0, 0.5},
        "below it for the place alone, however precise the pose is in it, the state is LOST");
  visit("recover", options.recover, "search the map when the pose is doubted");
  visit("snapshot_distance_m", options.snapshot_distance_m, Range{0.0, 1000.0},
        "keep the belief for pictures after so much travel; 0: at twelve moments of the run");
  visit.group("odometry_noise", options.odometry_noise);
  visit.group("velocity_noise", options.velocity_noise);
}

}  // namespace loopstone
