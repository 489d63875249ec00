#pragma once

#include <cstdint>
#include <span>

namespace loopstone {

/// What tells glass from what is solid, and from what moved.
struct GlassEvidenceNumbers {
  double seen = 0.9;
  double moves = 0.15;
  double least_turn = 0.09;
  double most_turn = 0.5;
  int turns = 5;
  double of_walls = 0.03;
  double of_moved = 0.12;
  double of_lattices = 0.03;
};
inline constexpr GlassEvidenceNumbers kGlassEvidence{};

template <typename Visitor>
void visit_numbers(const GlassEvidenceNumbers& n, Visitor&& visit) {
  visit("seen", n.seen, "chosen: share of the beams that do what their surface is taken to do");
  visit("moves", n.moves,
        "chosen: that what stands somewhere has come or gone from one look to the next: doors, "
        "people");
  visit("least_turn", n.least_turn,
        "chosen: smallest incidence [rad] from which on glass may let beams through");
  visit("most_turn", n.most_turn, "chosen: and the largest [rad]");
  visit("turns", n.turns, "chosen: so many incidences between them are tried, all alike likely");
  visit("of_walls", n.of_walls, "chosen: share of all surfaces, before anything was seen");
  visit("of_moved", n.of_moved, "chosen: likewise, of what comes and goes");
  visit("of_lattices", n.of_lattices,
        "chosen: likewise, of what lets a share of all beams through: grids, plants");
}

/// One beam that met a surface, or went through where it is.
struct SurfaceLook {
  double incidence_rad = 0.0;  ///< from the surface's normal
  bool returned = false;       ///< else something farther away did
};

/// How much more a surface's looks are to be expected of glass than of all else: the natural
/// logarithm of P(looks | glass) / P(looks | no glass). With a share s of the beams as they should
/// be:
///
///   solid    each look returns with s
///   lattice  each returns with q, and q is anything: r! t! / (r + t + 1)!
///   moved    a chain of two states, there or not, that changes from a look to the next with m;
///            there it returns with s, else with 1 - s
///   glass    returns with s below an incidence, with 1 - s above it; the mean over some of those
///
/// \param looks  in the order of time
/// Cost: O(looks). The forward algorithm: Rabiner 1989, "A tutorial on hidden Markov models", III.
[[nodiscard]] double glass_log_ratio(std::span<const SurfaceLook> looks);

/// P(glass), by what is known of surfaces before any look.
[[nodiscard]] double glass_probability(double log_ratio);

}  // namespace loopstone
