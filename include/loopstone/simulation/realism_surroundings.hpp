#pragma once

#include "loopstone/base/options.hpp"
#include "loopstone/simulation/realism_laser.hpp"

// What real surroundings are that drawn ones are not. One struct an effect; each is off by default.

namespace loopstone {

/// The map frame is turned by any angle against the walls.
struct RealismTurned {
  bool on = false;
};

/// Walls are not quite straight, corners not quite right, corridors bend.
struct RealismBent {
  bool on = false;
  double amplitude_m = 0.25;
  double wavelength_m = 25.0;
};

/// Doors and chairs that do not stand where they stood at the last visit.
struct RealismMoved {
  bool on = false;
  double every_s = 60.0;
  double share = 0.2;
  double distance_m = 0.7;
};

/// People who stand about, for minutes.
struct RealismStanders {
  bool on = false;
  int count = 12;
};

/// People who walk past, on top of `people`.
struct RealismWalkers {
  bool on = false;
  int count = 12;
};

/// Somebody follows the robot closely, half behind and half beside it, so that a laser that does
/// not look back sees them at the end of its beams.
struct RealismFollower {
  bool on = false;
  double from_s = 5.0;
  double to_s = 0.0;
  double gap_m = 0.4;
  double aside_m = 0.65;
  double body_m = 0.0;
};

/// Somebody walks ahead of it.
struct RealismAhead {
  bool on = false;
  double from_s = 5.0;
  double to_s = 0.0;
  double gap_m = 1.2;
  double body_m = 0.0;
};

/// People crowd around it, and go with it.
struct RealismCrowd {
  bool on = false;
  double from_s = 30.0;
  double to_s = 60.0;
  int count = 8;
  double radius_m = 0.9;
  double body_m = 0.2;
};

/// Panes that return only what meets them squarely, and let all else pass.
struct RealismGlass {
  bool on = false;
  double share = 0.12;
  double returns_within_rad = 0.2;
};

/// Panes in which the laser sees the room a second time.
struct RealismMirrors {
  bool on = false;
  double share = 0.03;
};

inline constexpr const char* kRealismBodyHelp =
    "radius of what the laser sees of each: a coat, a waist; 0: two legs";

template <typename Visitor>
void visit_options(RealismTurned& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
}

template <typename Visitor>
void visit_options(RealismBent& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("amplitude_m", options.amplitude_m, Range{0.0, 5.0}, "how far walls leave their lines");
  visit("wavelength_m", options.wavelength_m, Range{5.0, 1000.0}, "over what length");
}

template <typename Visitor>
void visit_options(RealismMoved& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("every_s", options.every_s, Range{1.0, 1e6}, "between one state of the world and the next");
  visit("share", options.share, Range{0.0, 1.0}, "of things that have been moved in each");
  visit("distance_m", options.distance_m, Range{0.0, 5.0}, "by up to so far");
}

template <typename Visitor>
void visit_options(RealismStanders& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("count", options.count, Range{0, 1000}, "of them");
}

template <typename Visitor>
void visit_options(RealismWalkers& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("count", options.count, Range{0, 1000}, "of them");
}

template <typename Visitor>
void visit_options(RealismFollower& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("from_s", options.from_s, Range{0.0, 1e6}, "when it begins");
  visit("to_s", options.to_s, Range{0.0, 1e6}, "when it ends; 0: never");
  visit("gap_m", options.gap_m, Range{0.0, 20.0}, "behind the robot's centre, along its way");
  visit("aside_m", options.aside_m, Range{-5.0, 5.0}, "to its left, where walls leave room");
  visit("body_m", options.body_m, Range{0.0, 1.0}, kRealismBodyHelp);
}

template <typename Visitor>
void visit_options(RealismAhead& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("from_s", options.from_s, Range{0.0, 1e6}, "when it begins");
  visit("to_s", options.to_s, Range{0.0, 1e6}, "when it ends; 0: never");
  visit("gap_m", options.gap_m, Range{0.3, 20.0}, "ahead of the robot's centre, along its way");
  visit("body_m", options.body_m, Range{0.0, 1.0}, kRealismBodyHelp);
}

template <typename Visitor>
void visit_options(RealismCrowd& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("from_s", options.from_s, Range{0.0, 1e6}, "when it begins");
  visit("to_s", options.to_s, Range{0.0, 1e6}, "when it ends; 0: never");
  visit("count", options.count, Range{0, 100}, "of people");
  visit("radius_m", options.radius_m, Range{0.4, 20.0}, "of the ring in which they stand");
  visit("body_m", options.body_m, Range{0.0, 1.0}, kRealismBodyHelp);
}

template <typename Visitor>
void visit_options(RealismGlass& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("share", options.share, Range{0.0, 1.0}, "of the walls, in panes of a metre");
  visit("returns_within_rad", options.returns_within_rad, Range{0.0, 1.5708},
        "incidence, from the normal, up to which a pane is seen");
}

template <typename Visitor>
void visit_options(RealismMirrors& options, Visitor&& visit) {
  visit("on", options.on, kRealismOnHelp);
  visit("share", options.share, Range{0.0, 1.0}, "of the walls, in panes of a metre");
}

}  // namespace loopstone
