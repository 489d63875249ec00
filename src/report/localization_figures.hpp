#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "loopstone/localization/localization_result.hpp"
#include "loopstone/report/localization_figures.hpp"

namespace loopstone {

/// A stretch of estimates with the same state: indices [first, last].
struct StateRun {
  LocalizationState state{};
  std::size_t first = 0;
  std::size_t last = 0;
};
/// Also ends where `breaks_before(i)` says that estimate i does not go on from the one before.
[[nodiscard]] std::vector<StateRun> state_runs(
    const std::vector<LocalizationEstimate>& estimates,
    const std::function<bool(std::size_t)>& breaks_before = {});

/// True when the pose is farther from the one before than a robot drives in the time between: it
/// was found elsewhere.
[[nodiscard]] bool is_jump(const LocalizationEstimate& before, const LocalizationEstimate& after);

/// The last estimate at or before the stamp, the first one when all come later. Nothing when there
/// are none.
[[nodiscard]] const LocalizationEstimate* estimate_at(const LocalizationResult& result,
                                                      Stamp stamp);

}  // namespace loopstone
