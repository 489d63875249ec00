#pragma once

#include "loopstone/base/options.hpp"
#include "loopstone/simulation/realism_laser.hpp"

// What robots do that ideal ones do not. One struct an effect; each is off by default.

namespace loopstone {

/// Stamps that are not the time of the measurement.
struct RealismStamps {
  bool on = false;
  double jitter_s = 0.004;
  double latency_s = 0.03;
  double late_share = 0.005;
  double late_s = 0.15;
  double drift_ppm = 100.0;
};

/// Messages that never arrive, in bursts and one by one.
struct RealismLoss {
  bool on = false;
  double share = 0.01;
  double every_s = 40.0;
  double longest_s = 2.5;
  bool odometry_too = true;
};

/// Wheels that are worse than their model, and slip at once now and then.
struct RealismWheels {
  bool on = false;
  double scale_error = 0.02;
  double imbalance = 0.005;
  double slip_every_m = 8.0;
  double slip_m = 0.15;
  double slip_rad = 0.08;
};

/// A gyro whose scale is off.
struct RealismGyro {
  bool on = false;
  double scale_error = 0.02;
  double bias_rad_s = 0.01;
};

/// The log begins while the robot drives: there is no standstill to learn from.
struct RealismRolling {
  bool on = false;
  double skipped_s = 6.0;
};

/// An uneven floor with sills and ramps: the laser pitches and rolls with the robot, beams meet the
/// floor or the ceiling.
struct RealismUneven {
  bool on = false;
  double slope_rad = 0.006;
  double sill_m = 0.012;
  double sill_every_m = 9.0;
  double ramp_rad = 0.06;
  double ramp_every_m = 120.0;
  double ceiling_m = 2.6;
};

/// Somebody lifts the robot and sets it down elsewhere; it then goes on with its visit.
struct RealismCarried {
  bool on = false;
  double at_s = 60.0;
  double distance_m = 3.0;
  double lift_s = 4.0;
  double turn_rad = 1.0;
};

template <typename Visitor>
void visit_options(RealismStamps& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("jitter_s", options.jitter_s, Range{0.0, 1.0}, "standard deviation of every stamp");
  visit("latency_s", options.latency_s, Range{0.0, 1.0}, "the laser's stamps are so late");
  visit("late_share", options.late_share, Range{0.0, 1.0}, "of stamps that are later still");
  visit("late_s", options.late_s, Range{0.0, 5.0}, "by up to so much");
  visit("drift_ppm", options.drift_ppm, Range{0.0, 10000.0},
        "the laser's clock runs faster or slower: between half and all of it, drawn once");
}

template <typename Visitor>
void visit_options(RealismLoss& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("share", options.share, Range{0.0, 1.0}, "of messages lost one by one");
  visit("every_s", options.every_s, Range{0.1, 1e6}, "mean time between bursts");
  visit("longest_s", options.longest_s, Range{0.0, 1000.0}, "a burst lasts up to so long");
  visit("odometry_too", options.odometry_too, "wheels and gyro are lost with the scans");
}

template <typename Visitor>
void visit_options(RealismWheels& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("scale_error", options.scale_error, Range{0.0, 0.5},
        "of distances, on top of wheels.scale_error: between half and all of it, drawn once");
  visit("imbalance", options.imbalance, Range{0.0, 0.2},
        "one side against the other, share of the distance: likewise");
  visit("slip_every_m", options.slip_every_m, Range{0.1, 1e6}, "mean way between slips");
  visit("slip_m", options.slip_m, Range{0.0, 10.0}, "wheels spin up to so far without moving it");
  visit("slip_rad", options.slip_rad, Range{0.0, 3.2}, "and turn up to so far, either way");
}

template <typename Visitor>
void visit_options(RealismGyro& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("scale_error", options.scale_error, Range{0.0, 0.5},
        "of the yaw rate: between half and all of it, drawn once");
  visit("bias_rad_s", options.bias_rad_s, Range{0.0, 1.0}, "on top of imu.bias_rad_s: likewise");
}

template <typename Visitor>
void visit_options(RealismRolling& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("skipped_s", options.skipped_s, Range{0.0, 1e6},
        "the log begins so long after the robot set off");
}

template <typename Visitor>
void visit_options(RealismUneven& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("slope_rad", options.slope_rad, Range{0.0, 0.5}, "root mean square slope of the floor");
  visit("sill_m", options.sill_m, Range{0.0, 0.2}, "height of the sills");
  visit("sill_every_m", options.sill_every_m, Range{1.0, 1e6}, "between sills");
  visit("ramp_rad", options.ramp_rad, Range{0.0, 0.5}, "slope of the ramps");
  visit("ramp_every_m", options.ramp_every_m, Range{8.0, 1e6}, "from one ramp up to the next");
  visit("ceiling_m", options.ceiling_m, Range{0.6, 100.0}, "height of the ceiling");
}

template <typename Visitor>
void visit_options(RealismCarried& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("at_s", options.at_s, Range{0.0, 1e6}, "when it is lifted");
  visit("distance_m", options.distance_m, Range{0.0, 100.0}, "how far it is carried");
  visit("lift_s", options.lift_s, Range{0.1, 1000.0}, "how long that takes");
  visit("turn_rad", options.turn_rad, Range{0.0, 3.1416}, "how far it is turned meanwhile");
}

}  // namespace loopstone
