#include "report/localization_figures.hpp"

#include <algorithm>
#include <cmath>

namespace loopstone {

double LocalizationFigures::share(LocalizationState state) const {
  switch (state) {
    case LocalizationState::kTracking:
      return tracking_share;
    case LocalizationState::kDoubtful:
      return doubtful_share;
    case LocalizationState::kLost:
      break;
  }
  return lost_share;
}

LocalizationFigures figures_of(const LocalizationResult& result) {
  LocalizationFigures figures;
  const std::vector<LocalizationEstimate>& estimates = result.estimates;
  if (estimates.empty()) {
    figures.lost_share = result.scans > 0 ? 1.0 : 0.0;
    return figures;
  }
  const LocalizationEstimate& first = estimates.front();
  double times_s[3] = {0.0, 0.0, 0.0};
  // Without a pose it was lost.
  times_s[static_cast<std::size_t>(LocalizationState::kLost)] =
      std::max(0.0, (first.stamp - result.start).seconds());
  double variance_xy = 0.0;
  double variance_yaw = 0.0;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    const LocalizationEstimate& e = estimates[i];
    // A state holds until the next estimate.
    if (i + 1 < estimates.size()) {
      times_s[static_cast<std::size_t>(e.state)] += (estimates[i + 1].stamp - e.stamp).seconds();
    }
    if (i > 0 && e.state != estimates[i - 1].state) ++figures.state_changes;
    if (e.state == LocalizationState::kTracking && !figures.first_tracking_s) {
      figures.first_tracking_s = (e.stamp - result.start).seconds();
      figures.first_tracking_m = e.travelled_m;
    }
    figures.refined += e.refined ? 1 : 0;
    figures.probability_mean += e.probability;
    figures.explained_mean += e.evidence.explained;
    figures.violations_mean += e.evidence.violations;
    figures.unexpected_mean += e.evidence.unexpected;
    variance_xy += 0.5 * (e.covariance(0, 0) + e.covariance(1, 1));
    variance_yaw += e.covariance(2, 2);
  }
  const double time_s = times_s[0] + times_s[1] + times_s[2];
  if (!(time_s > 0.0)) times_s[static_cast<std::size_t>(first.state)] = 1.0;
  const double whole = time_s > 0.0 ? time_s : 1.0;
  figures.tracking_share = times_s[static_cast<std::size_t>(LocalizationState::kTracking)] / whole;
  figures.doubtful_share = times_s[static_cast<std::size_t>(LocalizationState::kDoubtful)] / whole;
  figures.lost_share = times_s[static_cast<std::size_t>(LocalizationState::kLost)] / whole;
  const auto count = static_cast<double>(estimates.size());
  for (double* mean : {&figures.probability_mean, &figures.explained_mean, &figures.violations_mean,
                       &figures.unexpected_mean}) {
    *mean /= count;
  }
  figures.sigma_xy_rms_m = std::sqrt(variance_xy / count);
  figures.sigma_yaw_rms_rad = std::sqrt(variance_yaw / count);
  return figures;
}

std::vector<StateRun> state_runs(const std::vector<LocalizationEstimate>& estimates,
                                 const std::function<bool(std::size_t)>& breaks_before) {
  std::vector<StateRun> runs;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    const bool goes_on = !runs.empty() && runs.back().state == estimates[i].state &&
                         !(breaks_before && breaks_before(i));
    if (goes_on) {
      runs.back().last = i;
    } else {
      runs.push_back({estimates[i].state, i, i});
    }
  }
  return runs;
}

bool is_jump(const LocalizationEstimate& before, const LocalizationEstimate& after) {
  constexpr double kSlackM = 0.5;
  constexpr double kFastestMS = 3.0;
  const double distance_m =
      (after.map_T_robot.translation() - before.map_T_robot.translation()).norm();
  return distance_m > kSlackM + kFastestMS * (after.stamp - before.stamp).seconds();
}

const LocalizationEstimate* estimate_at(const LocalizationResult& result, Stamp stamp) {
  const auto& estimates = result.estimates;
  if (estimates.empty()) return nullptr;
  const auto later = std::upper_bound(
      estimates.begin(), estimates.end(), stamp,
      [](Stamp wanted, const LocalizationEstimate& e) { return wanted < e.stamp; });
  return later == estimates.begin() ? &estimates.front() : &*(later - 1);
}

}  // namespace loopstone
