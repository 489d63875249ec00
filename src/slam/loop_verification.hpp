#pragma once

#include <optional>
#include <vector>

#include "slam/loop_candidates.hpp"

namespace loopstone {

/// A closure as registration has it, and which of the newer submap's surfaces the older one saw.
struct VerifiedClosure {
  LoopClosure closure{};
  std::vector<bool> seen{};
};

/// Looks for the newer submap in the older one: the best pose of the whole window (branch and
/// bound), whether another one comes near it, refined on the surfaces, judged by overlap and
/// agreement. What passes waits for the graph. Nothing where no pose scores well enough to be
/// spoken of.
/// Deterministic. Cost: milliseconds; by appearance, tens of them.
[[nodiscard]] std::optional<VerifiedClosure> verify(const LoopCandidate& candidate,
                                                    const FrozenSubmap& older,
                                                    const FrozenSubmap& newer,
                                                    const LoopOptions& options,
                                                    const SubmapOptions& submap_options,
                                                    const GridMatchOptions& match_options);

}  // namespace loopstone
