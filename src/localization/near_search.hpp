#pragma once

#include <algorithm>
#include <optional>

#include "localization/confidence.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/localization/localization_map.hpp"
#include "loopstone/localization/localization_scan.hpp"

namespace loopstone {

/// How well a scan fits in one number, 1 at most: the share explained of what should be, less what
/// went through walls. What ended before a wall may be people: it says little, as do beams that
/// came back from nothing.
template <typename Fit>
[[nodiscard]] double quality_of(const Fit& fit) {
  constexpr double kSilent = 0.3;
  constexpr double kUnexpected = 0.2;
  return explained_of_rest(fit.explained, fit.unexpected) - fit.violations - kSilent * fit.silent -
         kUnexpected * fit.unexpected;
}

/// Where a scan that contradicts the map fits near the pose that was foretold: wheels slip, and
/// odometry lags, by some decimetres and tens of degrees.
/// \param foretold  map_T_robot with its covariance; the window is as large as a slip and that ask
/// \param least     quality that it must have there
/// \return map_T_robot of the one pose that explains the scan clearly better than any other nearby;
///         nothing where there is none, or more than one.
/// Cost: about 6 ms.
[[nodiscard]] std::optional<PoseWithCovariance2> find_nearby(const LocalizationScan& scan,
                                                             const LocalizationMap& map,
                                                             const PoseWithCovariance2& foretold,
                                                             double least);

/// When it is worth to look: at once, then after ever more scans in vain.
class NearSearchPace {
 public:
  [[nodiscard]] bool due() { return ++scans_ >= wait_; }
  void found() { wait_ = 0; }
  void in_vain() {
    constexpr int kMost = 16;
    scans_ = 0;
    wait_ = wait_ == 0 ? 2 : (2 * wait_ < kMost ? 2 * wait_ : kMost);
  }

 private:
  int scans_ = 0;
  int wait_ = 0;
};

}  // namespace loopstone
