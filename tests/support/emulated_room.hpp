#pragma once

#include <functional>

namespace loopstone::test {

/// What an emulated scanner sees; it is asked beam by beam, in the order of the beams.
struct EmulatedRoom {
  /// Range [m] at a time since the emulator began [s], at an angle of the scanner's frame,
  /// counter-clockwise from its x axis; +inf: nothing.
  std::function<double(double time_s, double angle_rad)> range_m{};
  /// Brightness of the echo from there.
  std::function<int(double angle_rad)> brightness = [](double) { return 1000; };
};

}  // namespace loopstone::test
