#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "loopstone/localization/localization_result.hpp"

namespace loopstone {

/// Figures that follow from the estimates.
struct LocalizationFigures {
  double tracking_share = 0.0;  ///< of the time from the first scan to the last
  double doubtful_share = 0.0;
  double lost_share = 0.0;
  std::optional<double> first_tracking_s{};  ///< after the first scan
  std::optional<double> first_tracking_m{};  ///< by odometry
  std::int64_t state_changes = 0;            ///< the first state is none
  std::int64_t refined = 0;                  ///< estimates that registration to the map refined
  double probability_mean = 0.0;             ///< over the estimates, as all that follow
  double explained_mean = 0.0;
  double violations_mean = 0.0;
  double unexpected_mean = 0.0;
  double sigma_xy_rms_m = 0.0;  ///< root of the mean of (var x + var y) / 2
  double sigma_yaw_rms_rad = 0.0;

  [[nodiscard]] double share(LocalizationState state) const;
};
[[nodiscard]] LocalizationFigures figures_of(const LocalizationResult& result);

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
