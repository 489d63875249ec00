#pragma once

#include <optional>
#include <vector>

#include "slam/loop_candidates.hpp"

namespace loopstone {

/// When two submaps are found to show one place.
struct LoopVerificationNumbers {
  std::size_t probe_points = 350;
  double bend_m = 0.03;
  double bend_rad = 0.005;
  double elsewhere_m = 1.0;
  double elsewhere_rad = 0.35;
  double appearance_score = 0.5;
  double appearance_overlap = 0.5;
  double appearance_agreement = 0.85;
  double stricter = 0.05;
  double rival_agreement = 0.9;
};
inline constexpr LoopVerificationNumbers kLoopVerification{};

template <typename Visitor>
void visit_numbers(const LoopVerificationNumbers& n, Visitor&& visit) {
  visit("probe_points", n.probe_points,
        "chosen: surfaces of the newer submap that the search uses, evenly spaced");
  visit("bend_m", n.bend_m,
        "chosen: what a whole submap's own bending adds to the uncertainty of a closure");
  visit("bend_rad", n.bend_rad, "chosen: the same of the heading");
  visit("elsewhere_m", n.elsewhere_m, "chosen: a pose this far from the best one is another place");
  visit("elsewhere_rad", n.elsewhere_rad, "chosen: or one turned by so much");
  visit("appearance_score", n.appearance_score,
        "chosen: what was found without a pose's help must reach at least this score");
  visit("appearance_overlap", n.appearance_overlap, "chosen: this overlap");
  visit("appearance_agreement", n.appearance_agreement, "chosen: and this agreement");
  visit("stricter", n.stricter,
        "chosen: as few false poses agree so well by both submaps' surfaces as by this more of the "
        "overlap");
  visit("rival_agreement", n.rival_agreement,
        "chosen: across a break a second pose, or another place, that agrees by less than this "
        "share of the first one's agreement is no rival, however well it scores");
}

/// A closure as registration has it, and which of the newer submap's surfaces the older one shows,
/// too.
struct VerifiedClosure {
  LoopClosure closure{};
  std::vector<bool> seen{};
};

/// Looks for the newer submap in the older one: the best pose of the whole window (branch and
/// bound), whether another one comes near it, refined on the surfaces, judged by overlap and
/// agreement. What passes waits for the graph. Nothing where no pose scores well enough to be
/// spoken of.
/// Where that fails and the candidate may be compared either way, the older one is looked for in
/// the newer: a submap that saw much does not lie in one that saw a part of it.
/// Deterministic. Cost: milliseconds; by appearance, tens of them.
[[nodiscard]] std::optional<VerifiedClosure> verify(const LoopCandidate& candidate,
                                                    const FrozenSubmap& older,
                                                    const FrozenSubmap& newer,
                                                    const LoopOptions& options,
                                                    const SubmapOptions& submap_options,
                                                    const GridMatchOptions& match_options);

}  // namespace loopstone
