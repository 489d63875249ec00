#pragma once

#include <array>

#include "loopstone/base/rng.hpp"
#include "loopstone/sensor/laser_scan.hpp"
#include "loopstone/simulation/realism.hpp"

namespace loopstone {

/// Something that lies before the laser for a while. It has a shape that travels with the robot;
/// its returns are noisy, for the laser is too near to it to measure.
class BlockedLaser {
 public:
  BlockedLaser(const RealismBlocked& options, Rng rng);
  /// Draws for every beam of every scan, blocked or not.
  void spoil(LaserScan& scan, double time_s);
  [[nodiscard]] bool is_blocked(double time_s) const;

 private:
  [[nodiscard]] double shape_at(double angle_rad) const;
  RealismBlocked options_;
  Rng rng_;
  std::array<double, 3> sizes_{};
  std::array<double, 3> phases_rad_{};
};

/// Dirt on the laser's window.
class DirtyWindow {
 public:
  DirtyWindow(const RealismDirty& options, Rng rng) : options_(options), rng_(rng) {}
  /// Draws for every beam of every scan.
  void spoil(LaserScan& scan);

 private:
  RealismDirty options_;
  Rng rng_;
};

}  // namespace loopstone
