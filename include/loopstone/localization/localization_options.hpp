#pragma once

#include <string>

#include "loopstone/base/options.hpp"

namespace loopstone {

struct LocalizationOptions {
  int particles_max = 2000;  ///< of all hypotheses together
  int particles_min = 100;   ///< of each
  std::string motion =
      "auto";  ///< "auto": odometry with its own covariance, gyro-aided where there is one
  std::string sensor = "likelihood_field";
  std::string resampling = "systematic";
  int beams = 90;                     ///< of a scan, that particles are weighed with
  double update_distance_m = 0.1;     ///< particles are weighed after so much travel
  double update_angle_rad = 0.1;      ///< or after so much turning
  double tracking_probability = 0.9;  ///< from here up the state is TRACKING
  double lost_probability = 0.1;      ///< below it for the place alone, LOST
  bool recover = true;                ///< search the map when the pose is doubted
  double snapshot_distance_m =
      0.0;  ///< keep the belief after so much travel; 0: at twelve moments of the run
};

template <typename Visitor>
void visit_options(LocalizationOptions& options, Visitor&& visit) {
  visit("particles_max", options.particles_max, Range{10, 1e6},
        "particles of all hypotheses together");
  visit("particles_min", options.particles_min, Range{10, 1e5}, "particles of each hypothesis");
  visit("motion", options.motion, OneOf{{"auto", "odometry", "velocity"}},
        "auto: odometry's own covariance, gyro-aided; or the models of Thrun, tables 5.6 and 5.3");
  visit("sensor", options.sensor, OneOf{{"likelihood_field", "beam_skipping", "beam"}},
        "how a scan weighs a particle");
  visit("resampling", options.resampling,
        OneOf{{"systematic", "stratified", "residual", "multinomial"}},
        "how particles are drawn anew");
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
}

}  // namespace loopstone
