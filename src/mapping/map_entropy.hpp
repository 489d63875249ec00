#pragma once

#include <cstdint>
#include <span>

#include "loopstone/base/parallel_for.hpp"
#include "mapping/judged_scans.hpp"

namespace loopstone {

struct MapEntropy {
  std::int64_t points = 0;    ///< at which it was measured; 0: no wall was seen in two visits
  double mean_nats = 0.0;     ///< of the whole map
  double stretch_nats = 0.0;  ///< at the same points, of the stretch alone that saw the point
};

/// Mean map entropy: the mean over points q of h(q) = 1/2 ln |2 pi e S(q)|, S the covariance of all
/// returns within 0.3 m of q that face the same way. Droeschel, Stueckler and Behnke 2014, eq. 18;
/// in the plane, and by facing, so that the two sides of a thin wall are not one thick wall. It is
/// taken where a second visit saw the wall as well. An entropy alone says little, since it grows
/// with every corner; against that of a single stretch of travel at the same points, what the poses
/// add remains: ln of how many times thicker the walls are.
[[nodiscard]] MapEntropy map_entropy(std::span<const JudgedScan> scans, Threads threads);

}  // namespace loopstone
