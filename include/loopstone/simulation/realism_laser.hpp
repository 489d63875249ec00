#pragma once

#include "loopstone/base/options.hpp"

// What real laser scanners do that ideal ones do not. One struct an effect; each is off by default.

namespace loopstone {

/// Ranges that are off, by an amount that the distance and the surface decide. Defaults after the
/// UTM-30LX data sheet (repeatability 10 mm to 10 m, 30 mm to 30 m; 13 mrad beam) and Kneip et al.
/// 2009, "Characterization of the compact Hokuyo URG-04LX" (bias by distance and incidence).
struct RealismRange {
  bool on = false;
  double bias_m = 0.01;
  double scale_error = 0.003;
  double noise_per_m = 0.001;
  double beam_width_rad = 0.01;
};

/// A beam with a width, part of which meets a nearer surface than the rest. Source: Tuley,
/// Vandapel, Hebert 2005, "Analysis and removal of artifacts in 3-D LADAR data".
struct RealismMixed {
  bool on = false;
  double beam_width_rad = 0.01;
  double least_step_m = 0.15;
  double blend_m = 1.5;
};

/// Beams without return: dark surfaces, far ones, and ones met at a grazing angle.
struct RealismDropouts {
  bool on = false;
  double share = 0.003;
  double dark_share = 0.06;
  double dark_reach_m = 6.0;
  double grazing_rad = 1.3;
  double seen_as_free = 0.5;
};

/// Ranges in steps: centimetres in a SICK LMS, millimetres in a Hokuyo.
struct RealismSteps {
  bool on = false;
  double step_m = 0.01;
};

/// Beams leave one after the other, and no file says so.
struct RealismSweep {
  bool on = false;
  double sweep_s = 0.075;
};

/// The laser does not sit where the robot's file says.
struct RealismMount {
  bool on = false;
  double x_m = 0.03;
  double y_m = 0.03;
  double yaw_rad = 0.035;
};

/// Something lies before the laser for a while: noisy returns all around that go with the robot.
struct RealismBlocked {
  bool on = false;
  double at_s = 30.0;
  double length_s = 15.0;
  double nearest_m = 0.05;
  double farthest_m = 0.29;
  double seen_share = 0.03;
};

/// Dirt on the window: in one sector most beams return from it, or nothing.
struct RealismDirty {
  bool on = false;
  double middle_rad = 0.8;
  double width_rad = 0.6;
  double share = 0.7;
};

/// The scanner hangs upside down and the log says that it stands: left is right.
struct RealismUpsideDown {
  bool on = false;
};

inline constexpr const char* kRealismOnHelp = "whether it happens; --realism sets it";

template <typename Visitor>
void visit_options(RealismRange& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("bias_m", options.bias_m, Range{0.0, 1.0},
        "all ranges too long or too short: between half and all of it, drawn once");
  visit("scale_error", options.scale_error, Range{0.0, 0.2}, "likewise, share of the range");
  visit("noise_per_m", options.noise_per_m, Range{0.0, 0.1},
        "standard deviation that grows with the range");
  visit("beam_width_rad", options.beam_width_rad, Range{0.0, 0.1},
        "spreads ranges on surfaces met at an angle");
}

template <typename Visitor>
void visit_options(RealismMixed& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("beam_width_rad", options.beam_width_rad, Range{0.0001, 0.1}, "of the beam");
  visit("least_step_m", options.least_step_m, Range{0.0, 10.0},
        "surfaces nearer together than this are told as one");
  visit("blend_m", options.blend_m, Range{0.0, 100.0},
        "of surfaces nearer together than this a range between them may come; else one of both");
}

template <typename Visitor>
void visit_options(RealismDropouts& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("share", options.share, Range{0.0, 1.0}, "of beams that are lost anywhere");
  visit("dark_share", options.dark_share, Range{0.0, 1.0}, "of surfaces that are dark");
  visit("dark_reach_m", options.dark_reach_m, Range{0.1, 100.0},
        "a dark surface this far away returns half of the beams");
  visit("grazing_rad", options.grazing_rad, Range{0.0, 1.5707},
        "incidence, from the normal, at which beams begin to be lost; all are edge-on");
  visit("seen_as_free", options.seen_as_free, Range{0.0, 1.0},
        "share of lost beams that the log calls beyond range; the others are bad");
}

template <typename Visitor>
void visit_options(RealismSteps& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("step_m", options.step_m, Range{0.0001, 1.0}, "ranges are whole steps");
}

template <typename Visitor>
void visit_options(RealismSweep& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("sweep_s", options.sweep_s, Range{0.0, 1.0},
        "true time from the first beam to the last; the log says 0");
}

template <typename Visitor>
void visit_options(RealismMount& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("x_m", options.x_m, Range{0.0, 10.0},
        "ahead or behind of where the file says: between half and all of it, drawn once");
  visit("y_m", options.y_m, Range{0.0, 10.0}, "likewise, to the side");
  visit("yaw_rad", options.yaw_rad, Range{0.0, 3.2}, "likewise, turned");
}

template <typename Visitor>
void visit_options(RealismBlocked& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("at_s", options.at_s, Range{0.0, 1e6}, "when it begins");
  visit("length_s", options.length_s, Range{0.0, 1e6}, "how long it lasts");
  visit("nearest_m", options.nearest_m, Range{0.0, 5.0}, "of its returns");
  visit("farthest_m", options.farthest_m, Range{0.0, 5.0}, "of its returns");
  visit("seen_share", options.seen_share, Range{0.0, 1.0}, "share of beams that still pass");
}

template <typename Visitor>
void visit_options(RealismDirty& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("middle_rad", options.middle_rad, Range{-3.1416, 3.1416}, "of the sector, in the scan");
  visit("width_rad", options.width_rad, Range{0.0, 6.2832}, "of the sector");
  visit("share", options.share, Range{0.0, 1.0}, "of its beams that are spoilt");
}

template <typename Visitor>
void visit_options(RealismUpsideDown& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
}

}  // namespace loopstone
