#include "localization/pose_evidence.hpp"

#include <algorithm>
#include <cmath>

#include "loopstone/base/error_function.hpp"
#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/pose_distance.hpp"

namespace loopstone {

namespace {

/// Share of the newest scan in the mean.
constexpr double kNewestGood = 0.3;
constexpr double kNewestBad = 0.7;
/// Share of what was explained that is forgotten with each scan without returns.
constexpr double kForgotten = 0.05;

double followed(double mean, double value, bool worse) {
  return mean + (worse ? kNewestBad : kNewestGood) * (value - mean);
}

}  // namespace

double precision_of(const Eigen::Matrix3d& covariance) {
  constexpr double kWithinM = 0.2;
  constexpr double kWithinRad = 5.0 * kPi / 180.0;
  const double half_trace = 0.5 * (covariance(0, 0) + covariance(1, 1));
  const double half_gap = 0.5 * (covariance(0, 0) - covariance(1, 1));
  const double longest = half_trace + hypotenuse(half_gap, covariance(0, 1));
  const auto within = [](double bound, double variance) {
    return error_function(bound / std::sqrt(2.0 * std::max(variance, 1e-12)));
  };
  return within(kWithinM, longest) * within(kWithinRad, covariance(2, 2));
}

double mass_near(const PlaceBelief& place, const Pose2& map_T_robot) {
  constexpr double kNearM = 0.5;
  constexpr double kNearRad = 0.35;
  double near = 0.0;
  for (std::size_t i = 0; i < place.particles.size(); ++i) {
    if (is_within(place.particles.states()[i], map_T_robot, kNearM, kNearRad))
      near += std::exp(place.particles.log_weights()[i]);
  }
  return near * std::exp(place.log_mass);
}

void RecentFit::add(const BeamFit& fit) {
  if (!mean_) mean_ = fit;
  mean_->explained = followed(mean_->explained, fit.explained, fit.explained < mean_->explained);
  mean_->violations =
      followed(mean_->violations, fit.violations, fit.violations > mean_->violations);
  mean_->unexpected =
      followed(mean_->unexpected, fit.unexpected, fit.unexpected > mean_->unexpected);
  mean_->silent = followed(mean_->silent, fit.silent, fit.silent > mean_->silent);
  mean_->known = followed(mean_->known, fit.known, fit.known < mean_->known);
}

void FitAlongWay::add(const BeamFit& fit, double way_m) {
  const FitOverWay newest{fit.explained, fit.violations, fit.unexpected, fit.known, fit.silent};
  if (!mean_) mean_ = newest;
  const double share = 1.0 - std::exp(-way_m / length_m_);
  const auto follow = [&](double FitOverWay::*value) {
    (*mean_).*value += share * (newest.*value - (*mean_).*value);
  };
  follow(&FitOverWay::explained);
  follow(&FitOverWay::violations);
  follow(&FitOverWay::unexpected);
  follow(&FitOverWay::known);
  follow(&FitOverWay::silent);
}

void FitAlongWay::add_blind_scan(double way_m) {
  if (mean_) mean_->explained *= std::exp(-way_m / length_m_);
}

void RecentFit::add_blind_scan() {
  if (mean_) mean_->explained *= 1.0 - kForgotten;
}

}  // namespace loopstone
