#pragma once

#include <Eigen/Core>
#include <optional>

#include "loopstone/localization/localization_result.hpp"
#include "loopstone/localization/localization_scan.hpp"
#include "loopstone/localization/pose_belief.hpp"

namespace loopstone {

/// Probability that a Gaussian error stays within 0.2 m, along its longest axis, and 5 deg.
[[nodiscard]] double precision_of(const Eigen::Matrix3d& covariance);

/// Belief in those particles of a place that agree with a pose as far as their own spread lets
/// them. A place along a corridor may be long.
[[nodiscard]] double mass_near(const PlaceBelief& place, const Pose2& map_T_robot);

/// How the last scans fit the map: a mean that follows bad news at once and good news slowly.
class RecentFit {
 public:
  void add(const BeamFit& fit);
  /// A scan without returns: a scanner that sees nothing confirms nothing.
  void add_blind_scan();
  void reset() { mean_.reset(); }

  [[nodiscard]] BeamFit mean() const { return mean_.value_or(BeamFit{}); }

 private:
  std::optional<BeamFit> mean_{};
};

/// How the scans of the last metres fit the map. A robot that stands sees the same again and again,
/// so evidence counts by the way it was gathered on.
class FitAlongWay {
 public:
  /// \param length_m  over about so much way, exponentially less of what was before
  explicit FitAlongWay(double length_m) : length_m_(length_m) {}

  void add(const BeamFit& fit, double way_m);
  /// A scan without returns confirms nothing: what was explained is forgotten with the way.
  void add_blind_scan(double way_m);
  void reset() { mean_.reset(); }

  [[nodiscard]] bool any() const { return mean_.has_value(); }
  [[nodiscard]] FitOverWay mean() const { return mean_.value_or(FitOverWay{}); }

 private:
  double length_m_;
  std::optional<FitOverWay> mean_{};
};

}  // namespace loopstone
