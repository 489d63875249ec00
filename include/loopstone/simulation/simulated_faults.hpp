#pragma once

#include "loopstone/base/options.hpp"

namespace loopstone {

/// What is wrong with wheels and gyro. Of `strength` see SimulatedFaults.
enum class SimulatedOdometryFault {
  kNone,
  kMissing,   ///< wheels are not read; a gyro still is
  kStuck,     ///< wheels say that the robot stands
  kScaled,    ///< distances, and headings from wheels, are `strength` times too large
  kMirrored,  ///< left is right, of the gyro too
  kLagging,   ///< wheels and gyro are `strength` seconds late
  kJumping,   ///< every 10 s or so up to `strength` metres and radians come at once
};

constexpr auto words_of(SimulatedOdometryFault /*any*/) {
  using enum SimulatedOdometryFault;
  return std::array{Word{kNone, "none"},         Word{kMissing, "missing"},
                    Word{kStuck, "stuck"},       Word{kScaled, "scaled"},
                    Word{kMirrored, "mirrored"}, Word{kLagging, "lagging"},
                    Word{kJumping, "jumping"}};
}

/// What goes wrong on a robot beyond noise. Off by default.
struct SimulatedFaults {
  SimulatedOdometryFault odometry = SimulatedOdometryFault::kNone;
  double strength = 0.0;
  double from_s = 0.0;
  double to_s = 0.0;
  double scans_dropped = 0.0;
  double glass = 0.0;
};

template <typename Visitor>
void visit_options(SimulatedFaults& options, Visitor&& visit) {
  visit("odometry", options.odometry, "what is wrong with wheels and gyro");
  visit("strength", options.strength, Range{0.0, 100.0},
        "factor, seconds or metres of that fault; 0: the usual one, 1.6, 0.4 s or 1 m");
  visit("from_s", options.from_s, Range{0.0, 1e6}, "when it begins");
  visit("to_s", options.to_s, Range{0.0, 1e6}, "when it ends; 0: never");
  visit("scans_dropped", options.scans_dropped, Range{0.0, 1.0}, "share of scans that are lost");
  visit("glass", options.glass, Range{0.0, 1.0},
        "share of the walls, in pieces of half a metre, that return nothing");
}

}  // namespace loopstone
