// How the front end goes on after the laser has not held the pose for a while.

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/covariance.hpp"
#include "loopstone/registration/correlative_search.hpp"
#include "loopstone/slam/front_end.hpp"
#include "slam/front_end_numbers.hpp"
#include "slam/loop_coverage.hpp"
#include "slam/path_drift.hpp"
#include "slam/pose_search.hpp"
#include "slam/scan_edges.hpp"

namespace loopstone {

namespace {

PosePrior2 unknown_about(const Pose2& local_T_robot, double sigma_m, double sigma_rad) {
  return {local_T_robot,
          planar_covariance(std::min(sigma_m, kFrontEndRejoin.unknown_m),
                            std::min(sigma_rad, kFrontEndRejoin.unknown_rad))
              .inverse(),
          false};
}

/// Half of the window in which something is looked for.
double window_of(double sigma) { return kFrontEndRejoin.window_sigmas * sigma; }

}  // namespace

void FrontEnd::hold(Stamp stamp, const Pose2& local_T_robot,
                    const std::optional<OdometryReading>& odometry) {
  double usual = 0.0;
  if (own_.held) {
    const double seconds = std::max(0.0, (stamp - own_.held->stamp).seconds());
    usual = own_.held->usual_seconds > 0.0
                ? own_.held->usual_seconds +
                      (seconds - own_.held->usual_seconds) / kFrontEndRejoin.usual_memory
                : seconds;
  }
  own_.held = HeldScan{stamp, local_T_robot, odometry, usual};
}

bool FrontEnd::is_gap(Stamp stamp) const {
  if (!own_.held || own_.lost_in_a_row > 0) return false;
  return (stamp - own_.held->stamp).seconds() > longest_step_s();
}

double FrontEnd::longest_step_s() const {
  return std::max(kFrontEndRejoin.blind_s, kFrontEndRejoin.blind_steps * own_.held->usual_seconds);
}

bool FrontEnd::BlindMotion::is_short() const {
  return prior.holds_unobserved && odometry_m <= kFrontEndRejoin.short_m &&
         odometry_rad <= kFrontEndRejoin.short_rad;
}

FrontEnd::BlindMotion FrontEnd::blind_motion(Stamp stamp, const MotionGuess& guess,
                                             const std::optional<OdometryReading>& odometry) const {
  double gap_s = std::numeric_limits<double>::infinity();
  // Without odometry all along the speed is the laser's guess, and as good as none.
  if (odometry && own_.held && own_.lost_in_a_row == 0) {
    gap_s = (stamp - own_.held->stamp).seconds();
  }
  BlindMotion blind{unknown_about(
      guess.local_T_robot, predictor_.fastest_m_s() * gap_s / kFrontEndRejoin.window_sigmas,
      predictor_.fastest_rad_s() * gap_s / kFrontEndRejoin.window_sigmas)};
  blind.is_bounded = std::isfinite(gap_s);
  if (!own_.held || stamp <= own_.held->stamp || !own_.held->odometry || !odometry) return blind;
  const auto told = predictor_.told(*own_.held->odometry, own_.held->stamp, *odometry);
  if (!told) return blind;
  blind.prior = {own_.held->local_T_robot * told->motion,
                 planar_covariance(told->sigma_m, told->sigma_rad).inverse(), true};
  blind.odometry_m = std::max(std::hypot(told->motion.x, told->motion.y),
                              odometry->path_m - own_.held->odometry->path_m);
  blind.odometry_rad =
      std::max(std::abs(told->motion.yaw), odometry->turned_rad - own_.held->odometry->turned_rad);
  return blind;
}

/// Where the robot can't have gone far, the scan may also show what nobody saw before: it fits when
/// what it shows of the known does.
bool FrontEnd::explains(const MatchResult& match, std::span<const SurfacePoint> surfaces,
                        const MaxPyramid& known) const {
  if (match.score >= least_score()) return true;
  const double share = share_of(seen_by(known, match.target_T_source, surfaces));
  return share >= kFrontEndRejoin.partly_known &&
         match.score >= kFrontEndRejoin.partly_agreement * share;
}

std::optional<MatchResult> FrontEnd::recognise_near(std::span<const SurfacePoint> surfaces,
                                                    const PosePrior2& prior) const {
  const PosePrior2 there = in_submap(prior);
  const Submap& submap = active_.front().submap;
  const MatchResult match =
      match_to_grid(surfaces, submap.surfaces(), there.target_T_source, there, match_options_, 1);
  const bool fits = has_supported_pose(match.status) &&
                    chi2_from(there, match) <= kFrontEndRejoin.fits_chi2 &&
                    std::sqrt(position_variance_m2(match.covariance)) <= kFrontEndRejoin.tight_m &&
                    explains(match, surfaces, submap.freeze().search_pyramid(submap_options_, 0.0));
  if (!fits) return {};
  return in_local(match);
}

FrontEnd::Around FrontEnd::look_around(std::span<const SurfacePoint> surfaces,
                                       const PosePrior2& prior, bool drove_on) const {
  const PosePrior2 there = in_submap(prior);
  const auto points = search_points(surfaces);
  const SurfaceGrid& grid = active_.front().submap.surfaces();
  const Eigen::Matrix3d covariance = there.information.inverse();
  const SearchWindow anywhere{
      there.target_T_source,
      std::min(window_of(std::sqrt(position_variance_m2(covariance))), kFrontEndRejoin.around_m),
      std::min(window_of(std::sqrt(covariance(2, 2))), kPi)};
  const MaxPyramid pyramid =
      active_.front().submap.freeze().search_pyramid(submap_options_, anywhere.half_xy_m);
  const SearchResult best = search_about_robot(points, pyramid, anywhere, kPoseSearch.min_score);
  if (!best.found) return {};
  const auto refined = [&](const SearchResult& pose) {
    return match_to_grid(surfaces, grid, pose.target_T_source, there, match_options_, 0);
  };
  const auto is_good = [&](const MatchResult& match, double score) {
    if (!has_supported_pose(match.status)) return false;
    return match.score >= least_score() || (drove_on && score >= kFrontEndRejoin.partly_score &&
                                            explains(match, surfaces, pyramid));
  };
  const MatchResult match = refined(best);
  Around found{has_supported_pose(match.status) ? std::optional(in_local(match)) : std::nullopt,
               is_good(match, best.score)};
  if (found.explains &&
      std::sqrt(position_variance_m2(match.covariance)) <= kFrontEndRejoin.tight_m) {
    const SearchResult second =
        search_branch_and_bound(points, pyramid, anywhere, kFrontEndRejoin.ambiguous * best.score,
                                ExcludedPoses{best.target_T_source, kFrontEndRejoin.elsewhere_m,
                                              kFrontEndRejoin.elsewhere_rad});
    found.is_certain =
        !second.found || (drove_on && refined(second).score < match.score - kFrontEnd.score_drop);
  }
  if (found.is_certain || !drove_on) return found;
  // Few robots turn far in so short a time.
  SearchWindow ahead = anywhere;
  ahead.half_yaw_rad = std::min(ahead.half_yaw_rad, kFrontEndRejoin.usual_turn_rad);
  const double least =
      found.explains ? kFrontEndRejoin.ambiguous * best.score : kPoseSearch.min_score;
  const SearchResult usual = search_about_robot(points, pyramid, ahead, least);
  if (!usual.found) return found;
  const MatchResult there_too = refined(usual);
  if (has_supported_pose(there_too.status))
    found = {in_local(there_too), is_good(there_too, usual.score)};
  return found;
}

/// With odometry, a scan that does not fit where it says shows a place that the submap does not
/// know: one scan by itself is no reason to look for the robot elsewhere. Unless odometry says that
/// the robot stayed where all that it sees had been seen.
FrontEnd::Seen FrontEnd::rejoin(std::span<const SurfacePoint> surfaces, BlindMotion blind,
                                Stamp stamp, TrackedScan& tracked) {
  std::optional<MatchResult> match;
  BreakCause cause = BreakCause::kNoScans;
  if (blind.prior.holds_unobserved) {
    match = recognise_near(surfaces, blind.prior);
    if (!match && was_carried(surfaces, blind)) {
      cause = BreakCause::kCarried;
      const double gap_s = (stamp - own_.held->stamp).seconds();
      blind.prior =
          unknown_about(blind.prior.target_T_source,
                        std::max(kFrontEndRejoin.carried_m, kMotionPredictor.walking_m_s * gap_s /
                                                                kFrontEndRejoin.window_sigmas),
                        kFrontEndRejoin.unknown_rad);
    }
  }
  if (!match && !blind.prior.holds_unobserved) {
    const bool drove_on = cause == BreakCause::kNoScans && blind.is_bounded;
    const Around around = look_around(surfaces, blind.prior, drove_on);
    if (around.is_certain) {
      match = around.match;
    } else if (drove_on) {
      turn_to_match(surfaces, around, blind.prior);
    }
  }
  if (!match) {
    begin_piece(blind, cause, stamp, tracked);
    return {};
  }
  const Seen seen = take_match(*match, true, tracked);
  note_gap(blind, cause, stamp, tracked);
  return seen;
}

/// The scan contradicts the submap where odometry says that the robot hardly moved.
bool FrontEnd::was_carried(std::span<const SurfacePoint> surfaces, const BlindMotion& blind) const {
  if (options_.odometry == OdometryUse::kTrust || blind.odometry_m > kFrontEndRejoin.short_m)
    return false;
  const PosePrior2 there = in_submap(blind.prior);
  const Eigen::Matrix3d covariance = there.information.inverse();
  const double cell_m = submap_options_.search_cell_m;
  const SearchWindow window{there.target_T_source,
                            window_of(std::sqrt(position_variance_m2(covariance))) + 0.5 * cell_m,
                            window_of(std::sqrt(covariance(2, 2)))};
  const MaxPyramid pyramid =
      active_.front().submap.freeze().search_pyramid(submap_options_, window.half_xy_m);
  return !search_about_robot(search_points(surfaces), pyramid, window, kPoseSearch.min_score).found;
}

/// A place that is like its neighbours, as a corridor is, still tells the heading. If what is
/// expected explains the scan, the robot most likely went on as it came; else it may be where the
/// scan fits.
void FrontEnd::turn_to_match(std::span<const SurfacePoint> surfaces, const Around& around,
                             PosePrior2& prior) const {
  const PosePrior2 there = in_submap(prior);
  const MatchResult match = match_to_grid(surfaces, active_.front().submap.surfaces(),
                                          there.target_T_source, there, match_options_, 1);
  const bool goes_on = has_supported_pose(match.status) && match.score >= least_score();
  if (!goes_on && !around.match) return;
  const Eigen::Matrix3d covariance = prior.information.inverse();
  const Pose2 likeliest = goes_on ? in_local(match).target_T_source : around.match->target_T_source;
  prior = unknown_about(
      likeliest, std::sqrt(position_variance_m2(covariance)),
      goes_on || around.explains ? kFrontEndRejoin.turned_rad : std::sqrt(covariance(2, 2)));
}

/// \param odometry_guides  the guess was odometry's
TrackingStatus FrontEnd::tracking_of(const TrackedScan& tracked, bool odometry_guides,
                                     Stamp stamp) const {
  if (tracked.left_out) return TrackingStatus::kLost;
  if (tracked.path_break && tracked.path_break->bridge == BreakBridge::kNothing)
    return TrackingStatus::kLost;
  if (tracked.path_break && tracked.path_break->bridge == BreakBridge::kOdometry)
    return TrackingStatus::kBridged;
  if (!tracked.used || tracked.status == MatchStatus::kTooFewPairs) {
    const bool coasts =
        own_.held && (stamp - own_.held->stamp).seconds() <= kFrontEndRejoin.blind_s;
    return odometry_guides || coasts ? TrackingStatus::kBridged : TrackingStatus::kLost;
  }
  return tracked.status == MatchStatus::kDegenerate ? TrackingStatus::kDegenerate
                                                    : TrackingStatus::kTracked;
}

/// The laser holds the pose again, in the submap that it held it before.
bool FrontEnd::may_be_carried(const BlindMotion& blind, Stamp stamp,
                              const TrackedScan& tracked) const {
  return options_.odometry != OdometryUse::kTrust && blind.prior.holds_unobserved &&
         blind.odometry_m <= kFrontEndRejoin.short_m &&
         (stamp - own_.held->stamp).seconds() >= kFrontEndRejoin.carried_s &&
         rests_on_odometry(tracked.covariance);
}

FrontEnd::Seen FrontEnd::begin_along(BlindMotion blind, Stamp stamp, TrackedScan& tracked) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(
      tracked.covariance.topLeftCorner<2, 2>());
  const Eigen::Vector2d way = kFrontEndRejoin.carried_along_m * axes.eigenvectors().col(1);
  Eigen::Matrix3d covariance = tracked.covariance;
  covariance.topLeftCorner<2, 2>() += way * way.transpose();
  blind.prior.target_T_source = tracked.local_T_robot;
  blind.prior.information = covariance.inverse();
  begin_piece(blind, BreakCause::kNoScans, stamp, tracked);
  return {};
}

void FrontEnd::note_gap(const BlindMotion& blind, BreakCause cause, Stamp stamp,
                        TrackedScan& tracked) const {
  if (own_.lost_in_a_row > 0) return;
  tracked.path_break = PathBreak{.from = own_.held->stamp,
                                 .to = stamp,
                                 .cause = cause,
                                 .bridge = BreakBridge::kLaser,
                                 .odometry_m = blind.odometry_m,
                                 .covariance = tracked.covariance};
}

void FrontEnd::begin_piece(const BlindMotion& blind, BreakCause cause, Stamp stamp,
                           TrackedScan& tracked) {
  tracked.path_break = {
      .from = own_.held->stamp,
      .to = stamp,
      .cause = cause,
      .bridge = blind.prior.holds_unobserved ? BreakBridge::kOdometry : BreakBridge::kNothing,
      .odometry_m = blind.odometry_m,
      .covariance = blind.prior.information.inverse()};
  tracked.local_T_robot = blind.prior.target_T_source;
  tracked.covariance.setZero();
  tracked.status = MatchStatus::kConverged;
  tracked.score = 1.0;
  tracked.finished = end_piece();
  ++own_.piece;
  own_.lost_in_a_row = 0;
}

PosePrior2 FrontEnd::in_submap(const PosePrior2& prior) const {
  const Pose2& local_T_submap = active_.front().local_T_submap;
  return {local_T_submap.inverse() * prior.target_T_source,
          rotated(prior.information, local_T_submap.rotation().transpose()),
          prior.holds_unobserved};
}

MatchResult FrontEnd::in_local(MatchResult match) const {
  const Pose2& local_T_submap = active_.front().local_T_submap;
  match.target_T_source = local_T_submap * match.target_T_source;
  match.covariance = rotated(match.covariance, local_T_submap.rotation());
  return match;
}

std::vector<MotionGuess> FrontEnd::others_than_odometry(Stamp stamp) const {
  if (options_.odometry == OdometryUse::kTrust) return {};
  return predictor_.coast_guesses(stamp);
}

}  // namespace loopstone
