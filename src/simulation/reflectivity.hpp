#pragma once

#include <Eigen/Core>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/simulation/world.hpp"

namespace loopstone {

/// How bright echoes are, in no scanner's unit: a wall at hand gives about 300, a reflector ten
/// times that; at 10 m both give half of it, at 30 m a tenth, so that no single number divides
/// them.
class Reflectivity {
 public:
  Reflectivity(std::vector<Reflector> reflectors, Rng rng)
      : reflectors_(std::move(reflectors)), rng_(rng) {}

  /// Of a beam. Draws one number, whatever it meets; 0 where there is no echo.
  /// \param origin       of the beam, map frame [m]
  /// \param bearing_rad  its direction, map frame
  /// \param range_m      where it ends, without the noise of the range; may be +inf or NaN
  /// Cost: O(reflectors).
  [[nodiscard]] float intensity(const Eigen::Vector2d& origin, double bearing_rad, double range_m);

 private:
  std::vector<Reflector> reflectors_;
  Rng rng_;
};

}  // namespace loopstone
