#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "loopstone/localization/localization_map.hpp"
#include "loopstone/localization/localization_scan.hpp"
#include "loopstone/localization/pose_belief.hpp"
#include "loopstone/registration/map_match.hpp"

namespace loopstone {

/// Places that are followed at once.
inline constexpr int kPlacesMost = 300;
/// Fewer returns say nothing.
inline constexpr std::size_t kLeastReturns = 10;
/// Belief in the rest of the map while more places look alike than can be followed.
inline constexpr double kRestShare = 0.3;

/// Where on the map a scan may have been taken.
struct PlacesFound {
  std::vector<PoseBelief::Proposal> proposals{};  ///< the best first
  /// map_T_robot of each, as registration has it; a proposal is as wide as particles are drawn.
  std::vector<PoseWithCovariance2> matched{};
  double best_score = 0.0;  ///< [0, 1], share of the scan that the best explains
  bool complete = true;     ///< false: more places look alike than are proposed
};

/// Compares the scan with every place of the map. Cost: see match_on_map.
/// \param points_max  of the scan that are searched with
[[nodiscard]] PlacesFound find_places(const LocalizationScan& scan, const LocalizationMap& map,
                                      int points_max = MapMatchOptions{}.points_max);

/// Where near a pose it may have been taken: map_T_robot, the best first.
/// \param window  of map_T_robot
[[nodiscard]] std::vector<MatchResult> match_near(const LocalizationScan& scan,
                                                  const LocalizationMap& map,
                                                  const SearchWindow& window,
                                                  const MapMatchOptions& options);

/// When the map is searched again: at once, then after ever more travel.
class SearchPace {
 public:
  [[nodiscard]] bool due(double travelled_m) const { return travelled_m >= next_m_; }
  void searched(double travelled_m) {
    next_m_ = travelled_m + interval_m_;
    interval_m_ = std::min(1.5 * interval_m_, 5.0);
  }
  void calm() { interval_m_ = kFirst; }

 private:
  static constexpr double kFirst = 0.5;
  double next_m_ = 0.0;
  double interval_m_ = kFirst;
};

}  // namespace loopstone
