#pragma once

#include <array>

#include "loopstone/base/rng.hpp"
#include "loopstone/simulation/realism.hpp"
#include "simulation/beam_path.hpp"

namespace loopstone {

/// A beam with a width: looks at what its parts meet and makes one range of it.
class MixedPixels {
 public:
  MixedPixels(const RealismMixed& options, Rng rng) : options_(options), rng_(rng) {}

  /// From the middle of the beam, where its other parts are [rad].
  [[nodiscard]] std::array<double, 4> parts_rad() const;
  /// What the laser makes of the middle and of those parts; draws for every beam.
  [[nodiscard]] BeamEcho merged(const BeamEcho& middle, const std::array<BeamEcho, 4>& parts);

 private:
  RealismMixed options_;
  Rng rng_;
};

}  // namespace loopstone
