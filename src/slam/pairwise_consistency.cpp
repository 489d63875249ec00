#include "slam/pairwise_consistency.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {

namespace {

/// A correction this small can't spoil a map, true or not.
constexpr double kHarmlessM = 0.25;
constexpr double kHarmlessRad = 0.04;
/// One in a hundred, chi-square of 3 degrees of freedom.
constexpr double kAgreesChi2 = 11.345;
/// A second closure must tell the correction from none by three standard deviations.
constexpr double kNoticesChi2 = 9.0;
/// What the path between the closures' ends adds: standard deviations at rest and a metre of
/// travel.
constexpr double kPathRestM = 0.05;
constexpr double kPathM = 0.01;
constexpr double kPathRestRad = 0.01;
constexpr double kPathRad = 0.002;
/// Over more travel than this, agreement says little.
constexpr double kMostTravelM = 40.0;

Pose2 present(const MapSoFar& map, NodeId from, NodeId to) {
  return map.poses[static_cast<std::size_t>(from.index)].inverse() *
         map.poses[static_cast<std::size_t>(to.index)];
}

double travel_between(const MapSoFar& map, NodeId a, NodeId b) {
  return std::abs(map.travelled_m[static_cast<std::size_t>(a.index)] -
                  map.travelled_m[static_cast<std::size_t>(b.index)]);
}

/// By how much the map would have to move `to`, axes of `from` (as the closure's covariance has
/// it).
Eigen::Vector3d correction_of(const LoopClosure& closure, const MapSoFar& map) {
  const Pose2 now = present(map, closure.from, closure.to);
  const Pose2& measured = closure.from_T_to;
  return {measured.x - now.x, measured.y - now.y, wrap_angle(measured.yaw - now.yaw)};
}

/// The part of the correction that the closure insists on. Directions that it does not hold fade
/// out, compared with a harmless correction.
Eigen::Vector3d pull_of(const LoopClosure& closure, const MapSoFar& map) {
  const Eigen::Vector3d harmless(kHarmlessM * kHarmlessM, kHarmlessM * kHarmlessM,
                                 kHarmlessRad * kHarmlessRad);
  Eigen::Matrix3d sum = closure.covariance;
  sum.diagonal() += harmless;
  return harmless.cwiseProduct(sum.ldlt().solve(correction_of(closure, map)));
}

bool pulls_far(const Eigen::Vector3d& pull) { return pull.head<2>().norm() > kHarmlessM; }
bool turns_far(const Eigen::Vector3d& pull) { return std::abs(pull[2]) > kHarmlessRad; }

/// Whether what is this uncertain tells a pull from none, in position and in heading.
bool notices(const Eigen::Vector3d& pull, const Eigen::Matrix3d& covariance) {
  const Eigen::Vector2d shift = pull.head<2>();
  if (pulls_far(pull) &&
      shift.dot(covariance.topLeftCorner<2, 2>().ldlt().solve(shift)) < kNoticesChi2)
    return false;
  return !turns_far(pull) || pull[2] * pull[2] >= kNoticesChi2 * covariance(2, 2);
}

double chi2(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance) {
  return error.dot(covariance.ldlt().solve(error));
}

/// Neighbours along the path hold scans of each other: what deceives the one deceives the other.
/// Closures between submaps of which both pairs are neighbours are hardly two, and must each be
/// this good.
constexpr double kSharedOverlap = 0.75;
constexpr double kSharedAgreement = 0.85;

bool is_good(const LoopClosure& closure) {
  return closure.overlap >= kSharedOverlap && closure.agreement >= kSharedAgreement;
}

bool share_scans(const LoopClosure& a, const LoopClosure& b) {
  const auto neighbours = [](SubmapId i, SubmapId j) {
    return i.index <= j.index + 1 && j.index <= i.index + 1;
  };
  return neighbours(a.from_submap, b.from_submap) && neighbours(a.to_submap, b.to_submap);
}

}  // namespace

bool bends_nothing(const LoopClosure& closure, const MapSoFar& map) {
  const Eigen::Vector3d pull = pull_of(closure, map);
  return !pulls_far(pull) && !turns_far(pull);
}

bool are_consistent(const LoopClosure& a, const LoopClosure& b, const MapSoFar& map) {
  const double travel_m = travel_between(map, a.from, b.from) + travel_between(map, a.to, b.to);
  if (travel_m > kMostTravelM) return false;
  if (share_scans(a, b) && !(is_good(a) && is_good(b))) return false;
  // What b says of a's ends: a.from -> b.from -> b.to -> a.to.
  const Pose2 from_T_from = present(map, a.from, b.from);
  const Pose2 to_T_to = present(map, b.to, a.to);
  const Pose2 told = from_T_from * b.from_T_to * to_T_to;
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = from_T_from.rotation();
  // b's error in yaw swings a.to about b.to.
  const Eigen::Vector2d arm = (from_T_from * b.from_T_to).rotation() * to_T_to.translation();
  Eigen::Matrix3d swing = Eigen::Matrix3d::Identity();
  swing(0, 2) = -arm.y();
  swing(1, 2) = arm.x();
  const double sigma_m = kPathRestM + kPathM * travel_m;
  const double sigma_rad = kPathRestRad + kPathRad * travel_m;
  const Eigen::Matrix3d jacobian = swing * turn;
  Eigen::Matrix3d covariance = a.covariance + jacobian * b.covariance * jacobian.transpose();
  covariance.diagonal() +=
      Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad);
  const Eigen::Vector3d open(told.x - a.from_T_to.x, told.y - a.from_T_to.y,
                             wrap_angle(told.yaw - a.from_T_to.yaw));
  return chi2(open, covariance) <= kAgreesChi2 && notices(pull_of(a, map), covariance);
}

std::vector<std::size_t> accept_consistent(std::vector<LoopClosure>& closures,
                                           const MapSoFar& map) {
  const auto waits = [](const LoopClosure& c) { return c.state == ClosureState::kWaiting; };
  std::vector<std::size_t> accepted;
  for (std::size_t i = 0; i < closures.size(); ++i) {
    const LoopClosure& closure = closures[i];
    if (!waits(closure)) continue;
    const bool stands =
        bends_nothing(closure, map) ||
        std::any_of(closures.begin(), closures.end(), [&](const LoopClosure& other) {
          return &other != &closure && (other.stands() || waits(other)) &&
                 are_consistent(closure, other, map);
        });
    if (stands) accepted.push_back(i);
  }
  for (const std::size_t i : accepted) {
    closures[i].state = ClosureState::kStanding;
    closures[i].reason = ClosureReason::kNone;
  }
  return accepted;
}

}  // namespace loopstone
