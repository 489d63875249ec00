#pragma once

#include "loopstone/base/rng.hpp"

namespace loopstone {

/// Between half and all of a size, either sign: every seed is about equally hard.
[[nodiscard]] inline double systematic(double size, Rng& rng) {
  const double magnitude = size * rng.uniform(0.5, 1.0);
  return rng.below(2) == 0 ? magnitude : -magnitude;
}

}  // namespace loopstone
