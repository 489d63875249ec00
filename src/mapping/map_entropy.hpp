#pragma once

#include <cstdint>
#include <span>

#include "loopstone/base/parallel_for.hpp"
#include "mapping/judged_scans.hpp"

namespace loopstone {

/// What the entropy is taken by.
struct MapEntropyNumbers {
  double radius_m = 0.3;
  int most_queries = 3000;
  int most_returns = 400000;
  int least_points = 8;
  double least_variance_m2 = 1e-6;
};
inline constexpr MapEntropyNumbers kMapEntropy{};

template <typename Visitor>
void visit_numbers(const MapEntropyNumbers& n, Visitor&& visit) {
  visit("radius_m", n.radius_m,
        "chosen: returns this near to a point tell how sharp the map is there");
  visit("most_queries", n.most_queries, "chosen: bounds the cost; points at which it is taken");
  visit("most_returns", n.most_returns, "chosen: bounds the cost and the memory");
  visit("least_points", n.least_points, "chosen: a covariance of fewer points is none");
  visit("least_variance_m2", n.least_variance_m2,
        "chosen: (1 mm)^2; walls thinner than that are not told apart, and a perfect wall has an "
        "entropy");
}

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
