#pragma once

#include "loopstone/base/rng.hpp"
#include "loopstone/simulation/realism.hpp"
#include "simulation/beam_path.hpp"

namespace loopstone {

/// Beams whose light does not come back: from dark surfaces, and from those met at a grazing angle.
class BeamDropouts {
 public:
  BeamDropouts(const RealismDropouts& options, Rng rng);

  /// The range, or what the log has for a lost beam: +inf or NaN. Draws for every beam.
  [[nodiscard]] double measured(double range_m, const BeamEcho& met);
  /// How likely such a beam is lost.
  [[nodiscard]] double chance_of(const BeamEcho& met) const;

 private:
  RealismDropouts options_;
  Rng rng_;
  Rng surfaces_;  ///< never drawn from: a stream for each surface
};

}  // namespace loopstone
