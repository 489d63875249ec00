#include "localization/map_proof.hpp"

#include <algorithm>
#include <utility>

namespace loopstone {

namespace {

/// Path in vain after which there is as much doubt as there can be; path over which a place holds
/// that proves the map: longer than those do that are only similar.
constexpr double kInVainM = 5.0;
constexpr double kProvenM = 20.0;
/// A path that fitted is forgotten so much faster where scans don't fit.
constexpr double kForgotten = 2.0;

}  // namespace

double MapProof::doubt_at(double travelled_m, bool fits, double followed_m) {
  const double way_m = travelled_m - std::exchange(last_m_, travelled_m);
  if (proven_) return 0.0;
  held_m_ = std::clamp(held_m_ + (fits ? way_m : -kForgotten * way_m), 0.0, followed_m);
  if (!fits) in_vain_m_ = std::min(in_vain_m_ + way_m, kInVainM);
  proven_ = held_m_ >= kProvenM;
  return proven_ ? 0.0 : in_vain_m_ / kInVainM * (1.0 - held_m_ / kProvenM);
}

}  // namespace loopstone
