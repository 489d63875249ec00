#include "slam/pairwise_consistency.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <iterator>

#include "geometry/symmetric_matrix.hpp"
#include "loopstone/geometry/angle.hpp"
#include "slam/drives.hpp"

namespace loopstone {

namespace {

using Submaps = std::span<const SubmapRecord>;

Pose2 present(Submaps submaps, SubmapId from, SubmapId to) {
  return submaps[from.index].map_T_submap.inverse() * submaps[to.index].map_T_submap;
}

double travel_between(Submaps submaps, SubmapId a, SubmapId b) {
  return std::abs(submaps[a.index].travelled_m - submaps[b.index].travelled_m);
}

/// By how much the map would have to move `to`, axes of `from` (as the closure's covariance has
/// it).
Eigen::Vector3d correction_of(const LoopClosure& closure, Submaps submaps) {
  const Pose2 now = present(submaps, closure.from_submap, closure.to_submap);
  const Pose2& measured = closure.from_T_to;
  return {measured.x - now.x, measured.y - now.y, wrap_angle(measured.yaw - now.yaw)};
}

/// The part of the correction that the closure insists on. Directions that it does not hold fade
/// out, compared with a harmless correction.
Eigen::Vector3d pull_of(const LoopClosure& closure, Submaps submaps) {
  const Eigen::Vector3d harmless(
      kPairwiseConsistency.harmless_m * kPairwiseConsistency.harmless_m,
      kPairwiseConsistency.harmless_m * kPairwiseConsistency.harmless_m,
      kPairwiseConsistency.harmless_rad * kPairwiseConsistency.harmless_rad);
  Eigen::Matrix3d sum = closure.covariance;
  sum.diagonal() += harmless;
  return harmless.cwiseProduct(solve_symmetric(sum, correction_of(closure, submaps)));
}

bool pulls_far(const Eigen::Vector3d& pull) {
  return pull.head<2>().norm() > kPairwiseConsistency.harmless_m;
}
bool turns_far(const Eigen::Vector3d& pull) {
  return std::abs(pull[2]) > kPairwiseConsistency.harmless_rad;
}

/// Whether what is this uncertain tells a pull from none, in position and in heading.
bool notices(const Eigen::Vector3d& pull, const Eigen::Matrix3d& covariance) {
  const Eigen::Vector2d shift = pull.head<2>();
  if (pulls_far(pull) &&
      shift.dot(solve_symmetric<double, 2>(covariance.topLeftCorner<2, 2>(), shift)) <
          kPairwiseConsistency.notices_chi2)
    return false;
  return !turns_far(pull) ||
         pull[2] * pull[2] >= kPairwiseConsistency.notices_chi2 * covariance(2, 2);
}

double chi2(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance) {
  return error.dot(solve_symmetric(covariance, error));
}

bool is_good(const LoopClosure& closure) {
  return closure.overlap >= kPairwiseConsistency.shared_overlap &&
         closure.agreement >= kPairwiseConsistency.shared_agreement;
}

bool share_scans(const LoopClosure& a, const LoopClosure& b) {
  const auto neighbours = [](SubmapId i, SubmapId j) {
    return i.index <= j.index + 1 && j.index <= i.index + 1;
  };
  return neighbours(a.from_submap, b.from_submap) && neighbours(a.to_submap, b.to_submap);
}

}  // namespace

bool bends_nothing(const LoopClosure& closure, Submaps submaps) {
  const Eigen::Vector3d pull = pull_of(closure, submaps);
  return !pulls_far(pull) && !turns_far(pull);
}

bool are_consistent(const LoopClosure& a, const LoopClosure& b, Submaps submaps, bool are_adrift) {
  const double travel_m = travel_between(submaps, a.from_submap, b.from_submap) +
                          travel_between(submaps, a.to_submap, b.to_submap);
  if (travel_m > kPairwiseConsistency.travel_most_m) return false;
  if (share_scans(a, b) && !(is_good(a) && is_good(b))) return false;
  // What b says of a's ends: a.from -> b.from -> b.to -> a.to.
  const Pose2 from_T_from = present(submaps, a.from_submap, b.from_submap);
  const Pose2 to_T_to = present(submaps, b.to_submap, a.to_submap);
  const Pose2 told = from_T_from * b.from_T_to * to_T_to;
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = from_T_from.rotation();
  // b's error in yaw swings a.to about b.to.
  const Eigen::Vector2d arm = (from_T_from * b.from_T_to).rotation() * to_T_to.translation();
  Eigen::Matrix3d swing = Eigen::Matrix3d::Identity();
  swing(0, 2) = -arm.y();
  swing(1, 2) = arm.x();
  const double sigma_m =
      kPairwiseConsistency.path_rest_m + kPairwiseConsistency.path_share * travel_m;
  const double sigma_rad =
      kPairwiseConsistency.path_rest_rad + kPairwiseConsistency.path_rad_per_m * travel_m;
  const Eigen::Matrix3d jacobian = swing * turn;
  Eigen::Matrix3d covariance = a.covariance + jacobian * b.covariance * jacobian.transpose();
  covariance.diagonal() +=
      Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad);
  const Eigen::Vector3d open(told.x - a.from_T_to.x, told.y - a.from_T_to.y,
                             wrap_angle(told.yaw - a.from_T_to.yaw));
  return chi2(open, covariance) <= kPairwiseConsistency.agrees_chi2 &&
         (are_adrift || notices(pull_of(a, submaps), covariance));
}

Pose2 map_move_of(const LoopClosure& closure, Submaps submaps) {
  return submaps[closure.from_submap.index].map_T_submap * closure.from_T_to *
         submaps[closure.to_submap.index].map_T_submap.inverse();
}

Eigen::Vector2d map_pull_of(const LoopClosure& closure, Submaps submaps) {
  return submaps[closure.from_submap.index].map_T_submap.rotation() *
         pull_of(closure, submaps).head<2>();
}

bool is_foretold(const LoopClosure& closure, Submaps submaps) {
  const Eigen::Vector3d correction = correction_of(closure, submaps);
  return !pulls_far(correction) && !turns_far(correction);
}

std::vector<std::size_t> consistent_ones(std::span<const LoopClosure> closures, Submaps submaps) {
  const auto waits = [](const LoopClosure& c) { return c.state == ClosureState::kWaiting; };
  const Drives drives(submaps);
  std::vector<std::size_t> consistent;
  for (std::size_t i = 0; i < closures.size(); ++i) {
    const LoopClosure& closure = closures[i];
    if (!waits(closure)) continue;
    // What fits elsewhere as well may say nothing because it holds nothing. Where two drives lie to
    // one another before anything ties them says nothing at all.
    const bool adrift = drives.are_adrift(closure.from_submap, closure.to_submap);
    const bool harmless = !adrift && bends_nothing(closure, submaps);
    if (harmless && closure.second_score && !is_foretold(closure, submaps)) continue;
    const bool stands =
        harmless || std::any_of(closures.begin(), closures.end(), [&](const LoopClosure& other) {
          return &other != &closure && (other.stands() || waits(other)) &&
                 are_consistent(closure, other, submaps, adrift);
        });
    if (stands) consistent.push_back(i);
  }
  return consistent;
}

std::vector<std::size_t> first_ties(std::span<const LoopClosure> closures,
                                    std::vector<std::size_t> consistent, Submaps submaps) {
  const Drives drives(submaps);
  if (!drives.any_adrift()) return consistent;
  const auto is_adrift = [&](std::size_t i) {
    return drives.are_adrift(closures[i].from_submap, closures[i].to_submap);
  };
  const auto is_of_same_drives = [&](const LoopClosure& a, const LoopClosure& b) {
    return !drives.are_adrift(a.from_submap, b.from_submap) &&
           !drives.are_adrift(a.to_submap, b.to_submap);
  };
  const auto worth = [&](std::size_t i) { return closures[i].overlap * closures[i].agreement; };
  std::vector<std::size_t> adrift;
  std::ranges::copy_if(consistent, std::back_inserter(adrift), is_adrift);
  std::ranges::stable_sort(adrift, std::ranges::greater{}, worth);
  std::erase_if(consistent, is_adrift);
  std::vector<std::size_t> leading;
  for (std::size_t second = 1; second < adrift.size(); ++second) {
    const LoopClosure& b = closures[adrift[second]];
    const bool is_led = std::ranges::any_of(
        leading, [&](std::size_t i) { return is_of_same_drives(closures[i], b); });
    if (is_led) continue;
    for (std::size_t first = 0; first < second; ++first) {
      const LoopClosure& a = closures[adrift[first]];
      if (!is_of_same_drives(a, b) || !are_consistent(a, b, submaps, true)) continue;
      leading.insert(leading.end(), {adrift[first], adrift[second]});
      break;
    }
  }
  consistent.insert(consistent.end(), leading.begin(), leading.end());
  std::ranges::sort(consistent);
  return consistent;
}

}  // namespace loopstone
