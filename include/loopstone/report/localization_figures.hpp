#pragma once

#include <cstdint>
#include <optional>

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
/// Cost: one look at each estimate.
[[nodiscard]] LocalizationFigures figures_of(const LocalizationResult& result);

}  // namespace loopstone
