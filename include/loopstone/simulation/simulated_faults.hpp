#pragma once

#include <string>

#include "loopstone/base/options.hpp"

namespace loopstone {

/// What goes wrong on a robot beyond noise. Off by default.
struct SimulatedFaults {
  /// "missing": wheels are not read (a gyro still is); "stuck": they say that the robot stands;
  /// "scaled": distances, and headings from wheels, are `strength` times too large; "mirrored":
  /// left is right, of the gyro too; "lagging": wheels and gyro are `strength` seconds late;
  /// "jumping": every 10 s or so up to `strength` metres and radians come at once.
  std::string odometry = "none";
  double strength = 0.0;       ///< 0: the usual one: 1.6, 0.4 s, 1 m
  double from_s = 0.0;         ///< when the fault begins
  double to_s = 0.0;           ///< and ends; 0: it stays
  double scans_dropped = 0.0;  ///< share of the scans that never arrive
  double glass = 0.0;  ///< share of the walls, in pieces of half a metre, that return nothing
};

template <typename Visitor>
void visit_options(SimulatedFaults& options, Visitor&& visit) {
  visit("odometry", options.odometry,
        OneOf{{"none", "missing", "stuck", "scaled", "mirrored", "lagging", "jumping"}},
        "what is wrong with wheels and gyro");
  visit("strength", options.strength, Range{0.0, 100.0},
        "factor, seconds or metres of that fault; 0: the usual");
  visit("from_s", options.from_s, Range{0.0, 1e6}, "when it begins");
  visit("to_s", options.to_s, Range{0.0, 1e6}, "when it ends; 0: never");
  visit("scans_dropped", options.scans_dropped, Range{0.0, 1.0}, "share of scans that are lost");
  visit("glass", options.glass, Range{0.0, 1.0}, "share of the walls that return nothing");
}

}  // namespace loopstone
