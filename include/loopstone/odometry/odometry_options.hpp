#pragma once

#include <string>

#include "loopstone/base/options.hpp"

namespace loopstone {

/// How wheel and gyro readings become a pose.
struct OdometryOptions {
  std::string yaw =
      "gyro";  ///< "gyro": the gyro's wherever it is, else the wheels'; "wheels": the wheels'
  std::string integration =
      "arc";  ///< "arc": exact; "euler": straight along the old heading, as in textbooks
  std::string alignment =
      "interpolate";  ///< of sensors with different stamps: "interpolate" or "nearest"
  bool use_standstill =
      true;  ///< while the wheels stand, learn the gyro's bias and hold the heading
  double max_extrapolation_s = 0.2;  ///< beyond the newest reading, at constant velocity
  double distance_noise = 0.03;      ///< standard deviation of position after 1 m [m/sqrt(m)]
  double heading_noise_per_metre =
      0.02;  ///< of heading after 1 m [rad/sqrt(m)]; a tenth of it with a gyro
  double heading_noise_per_radian =
      0.1;  ///< of heading after 1 rad of turning [rad/sqrt(rad)]; a tenth with a gyro
};

template <typename Visitor>
void visit_options(OdometryOptions& options, Visitor&& visit) {
  visit("yaw", options.yaw, OneOf{{"gyro", "wheels"}},
        "where the heading comes from; gyro falls back to wheels where it is silent");
  visit("integration", options.integration, OneOf{{"arc", "euler"}},
        "exact arcs, or straight steps as in textbooks");
  visit("alignment", options.alignment, OneOf{{"interpolate", "nearest"}},
        "how readings with different stamps are brought together");
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
