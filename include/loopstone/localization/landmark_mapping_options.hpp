#pragma once

#include "loopstone/base/options.hpp"
#include "loopstone/localization/landmark_tracking_options.hpp"
#include "loopstone/sensor/reflectors.hpp"

namespace loopstone {

/// What makes a landmark of things seen again and again.
struct LandmarkMappingOptions {
  int sightings_min = 4;
  double baseline_min_m = 0.5;
  double clutter_share = 0.05;
  double robust_width = 3.0;
  double radius_max_m = 0.5;
  ReflectorOptions reflectors{};
  SightingNoise sightings{};
};

template <typename Visitor>
void visit_options(LandmarkMappingOptions& options, Visitor&& visit) {
  visit("sightings_min", options.sightings_min, Range{2, 1000},
        "a thing seen less often is no landmark");
  visit("baseline_min_m", options.baseline_min_m, Range{0.0, 100.0},
        "nor is one seen from places no farther apart: a mirror image passes for a thing there");
  visit("clutter_share", options.clutter_share, Range{0.0001, 0.9},
        "of what is seen that is no landmark");
  visit("robust_width", options.robust_width, Range{0.1, 1000.0},
        "standard deviations up to which a sighting counts nearly in full");
  visit("radius_max_m", options.radius_max_m, Range{0.0, 2.0},
        "of the roundest landmark; 0: all are taken to be flat");
  visit.group("reflectors", options.reflectors);
  visit.group("sightings", options.sightings);
}

}  // namespace loopstone
