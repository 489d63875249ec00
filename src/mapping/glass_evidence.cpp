#include "mapping/glass_evidence.hpp"

#include <algorithm>
#include <cmath>

namespace loopstone {

namespace {

constexpr double kSeen = kGlassEvidence.seen;

double log_of(bool as_told) { return std::log(as_told ? kSeen : 1.0 - kSeen); }

double log_sum(double a, double b) {
  const double most = std::max(a, b);
  return most + std::log(std::exp(a - most) + std::exp(b - most));
}

double log_solid(std::span<const SurfaceLook> looks) {
  double sum = 0.0;
  for (const SurfaceLook& look : looks) sum += log_of(look.returned);
  return sum;
}

double log_lattice(std::span<const SurfaceLook> looks) {
  const auto returned = static_cast<double>(std::ranges::count_if(looks, &SurfaceLook::returned));
  const double through = static_cast<double>(looks.size()) - returned;
  return std::lgamma(returned + 1.0) + std::lgamma(through + 1.0) -
         std::lgamma(returned + through + 2.0);
}

double log_moved(std::span<const SurfaceLook> looks) {
  const double stays = std::log(1.0 - kGlassEvidence.moves);
  const double moves = std::log(kGlassEvidence.moves);
  double there = std::log(0.5);
  double gone = there;
  for (const SurfaceLook& look : looks) {
    const double was_there = there;
    there = log_sum(there + stays, gone + moves) + log_of(look.returned);
    gone = log_sum(gone + stays, was_there + moves) + log_of(!look.returned);
  }
  return log_sum(there, gone);
}

double log_glass(std::span<const SurfaceLook> looks) {
  double sum = 0.0;
  for (int i = 0; i < kGlassEvidence.turns; ++i) {
    const double share = static_cast<double>(i) / (kGlassEvidence.turns - 1);
    const double turn = kGlassEvidence.least_turn *
                        std::pow(kGlassEvidence.most_turn / kGlassEvidence.least_turn, share);
    double log_turn = -std::log(static_cast<double>(kGlassEvidence.turns));
    for (const SurfaceLook& look : looks)
      log_turn += log_of(look.returned == (look.incidence_rad < turn));
    sum = i == 0 ? log_turn : log_sum(sum, log_turn);
  }
  return sum;
}

}  // namespace

double glass_log_ratio(std::span<const SurfaceLook> looks) {
  constexpr GlassEvidenceNumbers n = kGlassEvidence;
  constexpr double kSolid = 1.0 - n.of_walls - n.of_moved - n.of_lattices;
  constexpr double kOthers = 1.0 - n.of_walls;
  const double moved = std::log(n.of_moved / kOthers) + log_moved(looks);
  const double lattice = std::log(n.of_lattices / kOthers) + log_lattice(looks);
  const double solid = std::log(kSolid / kOthers) + log_solid(looks);
  return log_glass(looks) - log_sum(solid, log_sum(moved, lattice));
}

double glass_probability(double log_ratio) {
  const double before = std::log(kGlassEvidence.of_walls / (1.0 - kGlassEvidence.of_walls));
  return 1.0 / (1.0 + std::exp(-before - log_ratio));
}

}  // namespace loopstone
