#pragma once

#include "loopstone/base/options.hpp"
#include "loopstone/sensor/reflectors.hpp"

namespace loopstone {

/// How well a log's own sightings of landmarks (range and bearing) are known.
struct SightingNoise {
  double range_sigma_m = 0.15;
  double bearing_sigma_rad = 0.04;
};

struct LandmarkTrackingOptions {
  double max_range_m = 30.0;
  double clutter_share = 0.05;
  double tracking_probability = 0.9;
  double lost_probability = 0.1;
  bool recover = true;
  double snapshot_distance_m = 0.0;
  ReflectorOptions reflectors{};
  SightingNoise sightings{};
};

template <typename Visitor>
void visit_options(SightingNoise& options, Visitor&& visit) {
  visit("range_sigma_m", options.range_sigma_m, Range{0.0001, 100.0},
        "standard deviation of a range");
  visit("bearing_sigma_rad", options.bearing_sigma_rad, Range{0.00001, 1.0}, "and of a bearing");
}

template <typename Visitor>
void visit_options(LandmarkTrackingOptions& options, Visitor&& visit) {
  visit("max_range_m", options.max_range_m, Range{0.5, 500.0}, "no landmark is seen farther away");
  visit("clutter_share", options.clutter_share, Range{0.0001, 0.9},
        "of what is seen that is of no landmark of the map");
  visit("tracking_probability", options.tracking_probability, Range{0.5, 1.0},
        "from here up the state is TRACKING");
  visit("lost_probability", options.lost_probability, Range{0.0, 0.5},
        "below it for the place alone, however precise the pose is in it, the state is LOST");
  visit("recover", options.recover, "search the map when the place is doubted");
  visit("snapshot_distance_m", options.snapshot_distance_m, Range{0.0, 1000.0},
        "keep the belief for pictures after so much travel; 0: at twelve moments of the run");
  visit.group("reflectors", options.reflectors);
  visit.group("sightings", options.sightings);
}

}  // namespace loopstone
