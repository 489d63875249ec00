#pragma once

#include <vector>

#include "loopstone/base/options.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/sensor/landmark_reading.hpp"
#include "loopstone/sensor/laser_scan.hpp"

namespace loopstone {

/// How reflectors are told from all else that a laser sees.
struct ReflectorOptions {
  double brightness = 3.0;
  double intensity_min = 0.0;
  int beams_min = 2;
  double width_max_m = 0.5;
  double range_max_m = 30.0;
  double range_sigma_m = 0.01;
  double bearing_sigma_rad = 0.001;
  double stamp_sigma_s = 0.01;
};

template <typename Visitor>
void visit_options(ReflectorOptions& options, Visitor&& visit) {
  visit("brightness", options.brightness, Range{1.0, 1000.0},
        "a beam is bright from so many times the median intensity of beams of about its range on");
  visit("intensity_min", options.intensity_min, Range{0.0, 1e9},
        "and from this intensity on, in the scanner's own unit; 0: any");
  visit("beams_min", options.beams_min, Range{1, 1000}, "bright beams that make a reflector");
  visit("width_max_m", options.width_max_m, Range{0.01, 10.0}, "wider things are no reflectors");
  visit("range_max_m", options.range_max_m, Range{0.5, 500.0}, "farther ones are left out");
  visit("range_sigma_m", options.range_sigma_m, Range{0.0001, 10.0},
        "standard deviation of a reflector's range");
  visit("bearing_sigma_rad", options.bearing_sigma_rad, Range{0.00001, 1.0},
        "and of its bearing, beside that of a beam's width");
  visit("stamp_sigma_s", options.stamp_sigma_s, Range{0.0, 1.0},
        "and of the time at which it was seen: a robot that moves sees it elsewhere");
}

/// Finds reflectors by how bright they are. A beam is bright where its intensity is at least
/// `brightness` times the median of the beams whose range is about the same (within half an
/// octave), so that neither a scanner's unit nor the loss of light over the way matters, as long as
/// most of what it sees are no reflectors. Where fewer than 20 beams are of that range, the usual
/// is that of the next nearer ranges, or of the next farther ones times the ratio of the ranges,
/// whichever is more. Neighbouring
/// bright beams whose ranges go on make one reflector; a beam without a return between them does
/// not part it. Left out is what is too wide, reaches to the end of the scan, or is partly hidden
/// by something nearer, since its middle is not where it seems.
///
/// The point is where the mean of its beams met it, undone the motion during the sweep; its
/// covariance has the bearing's standard deviation, that of a beam's width (increment / sqrt(12)),
/// and the way that it moves past the robot while the stamp may be off.
/// \param velocity  of the robot in its own frame [m/s, m/s, rad/s]
/// \return in the order of the beams; none for a scan without intensities
/// Cost: O(beams log beams).
[[nodiscard]] std::vector<LandmarkObservation> find_reflectors(const LaserScan& scan,
                                                               const Pose2& robot_T_lidar,
                                                               const Tangent2& velocity,
                                                               const ReflectorOptions& options);

}  // namespace loopstone
