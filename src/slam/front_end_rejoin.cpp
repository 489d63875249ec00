// How the front end goes on after the laser has not held the pose for a while.

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "geometry/symmetric_matrix.hpp"
#include "loopstone/base/hypotenuse.hpp"
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

PosePrior2 expected_at(const Pose2& local_T_robot, const UntoldReach& reach, double turn_rad) {
  return {local_T_robot, reach.covariance(local_T_robot, turn_rad).inverse(), false};
}

/// Of a robot that somebody may have carried along what its laser leaves open.
/// \param seen  how it seemed to go meanwhile: along there that may be wholly wrong
Eigen::Matrix3d carried_along(const Eigen::Matrix3d& covariance, const Eigen::Vector2d& seen) {
  const SymmetricEigen<double, 2> axes =
      symmetric_eigen<double, 2>(covariance.topLeftCorner<2, 2>());
  const Eigen::Vector2d axis = axes.vectors.col(1);
  const Eigen::Vector2d way = hypotenuse(kFrontEndRejoin.carried_along_m, axis.dot(seen)) * axis;
  Eigen::Matrix3d carried = covariance;
  carried.topLeftCorner<2, 2>() += way * way.transpose();
  return carried;
}

/// Of a robot that most likely went on: beside what its laser sees least, such as the walls of a
/// corridor, it is where they say; along it may be anywhere within its reach. Nothing where it sees
/// all directions alike: then what it sees may repeat itself in any.
/// \param matched   covariance of the match where it is expected
/// \param along_m   one standard deviation of its reach
std::optional<Eigen::Matrix3d> gone_along(const Eigen::Matrix3d& matched, double along_m) {
  const SymmetricEigen<double, 2> axes = symmetric_eigen<double, 2>(matched.topLeftCorner<2, 2>());
  if (axes.values(1) < kFrontEndRejoin.along_ratio * kFrontEndRejoin.along_ratio * axes.values(0))
    return {};
  const Eigen::Vector2d way = along_m * axes.vectors.col(1);
  Eigen::Matrix3d covariance =
      planar_covariance(kFrontEndRejoin.beside_m, kFrontEndRejoin.along_rad);
  covariance.topLeftCorner<2, 2>() += way * way.transpose();
  return covariance;
}

/// Of a robot that odometry led on along what its laser leaves open: so far as odometry can tell;
/// beside that, and how it faces, as what it sees says.
/// \param matched  where it was expected, local frame
PosePrior2 led_along(const MatchResult& matched, const PosePrior2& told) {
  const SymmetricEigen<double, 2> axes =
      symmetric_eigen<double, 2>(matched.covariance.topLeftCorner<2, 2>());
  const Eigen::Vector2d axis = axes.vectors.col(1);
  const Eigen::Matrix2d covariance = told.information.inverse().topLeftCorner<2, 2>();
  const auto along = gone_along(matched.covariance, std::sqrt(axis.dot(covariance * axis)));
  if (!along) return told;
  return {matched.target_T_source, along->inverse(), true};
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
  predictor_.forget_unseen();
}

bool FrontEnd::is_gap(Stamp stamp) const {
  if (!own_.held) return false;
  const Stamp since = own_.lost_in_a_row > 0 ? *predictor_.last_stamp() : own_.held->stamp;
  return (stamp - since).seconds() > longest_step_s();
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
  const bool may_be_told =
      own_.held && stamp > own_.held->stamp && own_.held->odometry.has_value() && odometry;
  const auto told = may_be_told ? predictor_.told(*own_.held->odometry, own_.held->stamp, *odometry)
                                : std::optional<ToldMotion>{};
  if (!told) return untold_motion(stamp, guess, odometry);
  BlindMotion blind{{own_.held->local_T_robot * told->motion,
                     planar_covariance(told->sigma_m, told->sigma_rad).inverse(), true}};
  blind.odometry_m = std::max(hypotenuse(told->motion.x, told->motion.y),
                              odometry->path_m - own_.held->odometry->path_m);
  blind.odometry_rad =
      std::max(std::abs(told->motion.yaw), odometry->turned_rad - own_.held->odometry->turned_rad);
  return blind;
}

/// No farther than a robot can that is as fast as it has ever been seen to be, from where odometry
/// fell silent.
FrontEnd::BlindMotion FrontEnd::untold_motion(
    Stamp stamp, const MotionGuess& guess, const std::optional<OdometryReading>& odometry) const {
  // Without odometry all along the speed is the laser's guess, and as good as none.
  if (!odometry || !own_.held || own_.lost_in_a_row > kFrontEnd.most_lost)
    return {
        unknown_about(guess.local_T_robot, kFrontEndRejoin.unknown_m, kFrontEndRejoin.unknown_rad)};
  BlindMotion blind;
  PartlyToldMotion way{.untold_s = (stamp - own_.held->stamp).seconds()};
  if (own_.held->odometry) {
    const auto told =
        predictor_.partly_told(*own_.held->odometry, own_.held->stamp, *odometry, stamp);
    if (told) way = *told;
    if (way.told_m > kFrontEndRejoin.short_m) blind.odometry_m = way.told_m;
  }
  const double ahead_m = predictor_.fastest_m_s() * way.untold_s;
  const double back_m = predictor_.fastest_back_m_s() * way.untold_s;
  const double turned_rad = predictor_.fastest_rad_s() * way.untold_s;
  const double half_xy_m =
      0.5 * (ahead_m + back_m) + window_of(way.sigma_m) + kFrontEndRejoin.reach_rest_m;
  blind.reach = UntoldReach{
      .frame_T_start = own_.held->local_T_robot * way.before,
      .ahead_m = 0.5 * (ahead_m - back_m),
      .half_xy_m = half_xy_m,
      .half_yaw_rad = turned_rad + window_of(way.sigma_rad) + kFrontEndRejoin.reach_rest_rad,
      // Anywhere within, but it more likely went on than back.
      .sigma_m = std::min({half_xy_m / std::numbers::sqrt3,
                           hypotenuse(ahead_m / kFrontEndRejoin.window_sigmas, way.sigma_m),
                           kFrontEndRejoin.unknown_m}),
      .sigma_rad = std::min(hypotenuse(turned_rad / kFrontEndRejoin.window_sigmas, way.sigma_rad),
                            kFrontEndRejoin.unknown_rad),
      .after = way.after};
  blind.prior = expected_at(guess.local_T_robot, *blind.reach, blind.reach->sigma_rad);
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

MatchResult FrontEnd::match_at(std::span<const SurfacePoint> surfaces,
                               const PosePrior2& there) const {
  return match_to_grid(surfaces, active_.front().submap.surfaces(), there.target_T_source, there,
                       match_options_, 1);
}

bool FrontEnd::fits_along(const MatchResult& match, const PosePrior2& there) const {
  return match.status != MatchStatus::kTooFewPairs && match.score >= least_score() &&
         chi2_from(there, match) <= kFrontEndRejoin.fits_chi2 &&
         rests_on_odometry(in_local(match).covariance);
}

std::optional<MatchResult> FrontEnd::recognise_near(std::span<const SurfacePoint> surfaces,
                                                    const MatchResult& match,
                                                    const PosePrior2& there) const {
  // Nobody looks for a second place there: what is known in part must lie where odometry says.
  const bool is_expected = std::sqrt(position_variance_m2(there.information.inverse())) <=
                           kFrontEndRejoin.partly_prior_m;
  const bool fits =
      has_supported_pose(match.status) && chi2_from(there, match) <= kFrontEndRejoin.fits_chi2 &&
      std::sqrt(position_variance_m2(match.covariance)) <= kFrontEndRejoin.tight_m &&
      (match.score >= least_score() ||
       (is_expected &&
        explains(match, surfaces,
                 active_.front().submap.freeze().search_pyramid(submap_options_, 0.0))));
  if (!fits) return {};
  return in_local(match);
}

std::optional<MatchResult> FrontEnd::recognise_around(std::span<const SurfacePoint> surfaces,
                                                      const PosePrior2& prior) const {
  const PosePrior2 there = in_submap(prior);
  const auto points = search_points(surfaces);
  const FrozenSubmap frozen = active_.front().submap.freeze();
  const Eigen::Matrix3d covariance = there.information.inverse();
  const SearchWindow anywhere{
      there.target_T_source,
      std::min(window_of(std::sqrt(position_variance_m2(covariance))), kFrontEndRejoin.around_m),
      std::min(window_of(std::sqrt(covariance(2, 2))), kPi)};
  const MaxPyramid pyramid = frozen.search_pyramid(submap_options_, anywhere.half_xy_m);
  const SearchResult best = search_about_robot(points, pyramid, anywhere, kPoseSearch.min_score);
  if (!best.found) return {};
  const MatchResult match = match_to_grid(surfaces, active_.front().submap.surfaces(),
                                          best.target_T_source, there, match_options_, 0);
  if (!has_supported_pose(match.status) || match.score < least_score() ||
      std::sqrt(position_variance_m2(match.covariance)) > kFrontEndRejoin.tight_m) {
    return {};
  }
  const SearchResult second =
      search_branch_and_bound(points, pyramid, anywhere, kFrontEndRejoin.ambiguous * best.score,
                              ExcludedPoses{best.target_T_source, kFrontEndRejoin.elsewhere_m,
                                            kFrontEndRejoin.elsewhere_rad});
  if (second.found) return {};
  return in_local(match);
}

/// The best one, the next one elsewhere, the best that a usual turn leads to, and the one that is
/// expected.
std::vector<FrontEnd::Place> FrontEnd::places_within(std::span<const SurfacePoint> surfaces,
                                                     const UntoldReach& local_reach,
                                                     const PosePrior2& expected) const {
  const ActiveSubmap& target = active_.front();
  const UntoldReach reach = target.local_T_submap.inverse() * local_reach;
  const auto points = search_points(surfaces);
  std::vector<SearchWindow> windows = reach.windows();
  for (SearchWindow& window : windows)
    window.half_xy_m = std::min(window.half_xy_m, kFrontEndRejoin.around_m);
  const MaxPyramid known =
      target.submap.freeze().search_pyramid(submap_options_, windows.front().half_xy_m);
  std::vector<Place> places;
  const auto consider_match = [&](const MatchResult& match, double found_score) {
    const Pose2& pose = match.target_T_source;
    const auto is_there = [&](const Place& place) {
      const Pose2 apart = place.match.target_T_source.inverse() * pose;
      return apart.translation().norm() < kFrontEndRejoin.elsewhere_m &&
             std::abs(apart.yaw) < kFrontEndRejoin.elsewhere_rad;
    };
    if (!has_supported_pose(match.status) || !reach.holds(pose) ||
        std::ranges::any_of(places, is_there))
      return;
    const double seen = share_of(seen_by(known, pose, surfaces));
    places.push_back(
        {.match = match,
         .value =
             match.score + kFrontEndRejoin.new_counts * (1.0 - seen) -
             kFrontEnd.score_per_chi2 * std::min(kFrontEnd.most_chi2, chi2_from(expected, match)),
         .turn_rad = std::abs(reach.untold(pose).yaw),
         .explains = match.score >= least_score() || (found_score >= kFrontEndRejoin.partly_score &&
                                                      explains(match, surfaces, known))});
  };
  const auto consider = [&](const SearchResult& found) {
    if (!found.found) return;
    consider_match(match_to_grid(surfaces, target.submap.surfaces(), found.target_T_source, {},
                                 match_options_, 0),
                   found.score);
  };
  std::vector<SearchResult> bests;
  double best_score = 0.0;
  for (const SearchWindow& window : windows) {
    bests.push_back(search_about_robot(points, known, window, kPoseSearch.min_score));
    if (bests.back().found) best_score = std::max(best_score, bests.back().score);
    consider(bests.back());
  }
  if (best_score == 0.0) return {};
  const double least = std::max(kPoseSearch.min_score, kFrontEndRejoin.rival * best_score);
  for (std::size_t i = 0; i < windows.size(); ++i) {
    if (!bests[i].found) continue;
    consider(
        search_branch_and_bound(points, known, windows[i], least,
                                ExcludedPoses{bests[i].target_T_source, kFrontEndRejoin.elsewhere_m,
                                              kFrontEndRejoin.elsewhere_rad}));
  }
  if (windows.size() == 1) {
    SearchWindow usual = windows.front();
    usual.half_yaw_rad = std::min(usual.half_yaw_rad, kFrontEndRejoin.usual_turn_rad);
    consider(search_about_robot(points, known, usual, least));
  }
  const MatchResult there = match_at(surfaces, expected);
  if (there.score >= kFrontEndRejoin.partly_score) consider_match(there, there.score);
  return places;
}

/// Among places that are alike the one wins that explains most of what the scan shows of the known,
/// and of those that do nearly as well and face elsewhere one that explains the whole scan, or one
/// that the robot turned clearly less for.
FrontEnd::Ahead FrontEnd::look_ahead(std::span<const SurfacePoint> surfaces,
                                     const UntoldReach& reach, const PosePrior2& expected) const {
  PosePrior2 nearer = in_submap(expected);
  nearer.information.topLeftCorner<2, 2>() /=
      kFrontEndRejoin.usually_off * kFrontEndRejoin.usually_off;
  const std::vector<Place> places = places_within(surfaces, reach, nearer);

  if (places.empty()) return {};
  const Place* likeliest = &*std::ranges::max_element(places, {}, &Place::value);
  const double most = likeliest->value;
  const auto is_whole = [&](const Place& place) { return place.match.score >= least_score(); };
  for (const Place& place : places) {
    const double less_rad = likeliest->turn_rad - place.turn_rad;
    if (place.value < most - kFrontEndRejoin.alike ||
        std::abs(less_rad) <= kFrontEndRejoin.usual_turn_rad)
      continue;
    if (is_whole(place) == is_whole(*likeliest) ? less_rad > 0.0 : is_whole(place))
      likeliest = &place;
  }
  const auto is_rival = [&](const Place& place) {
    return &place != likeliest && place.value > likeliest->value - kFrontEnd.score_drop;
  };
  const MatchResult& match = likeliest->match;
  const bool is_tight =
      std::sqrt(position_variance_m2(match.covariance)) <= kFrontEndRejoin.tight_m;
  const auto faces_elsewhere = [&](const Place& place) {
    const double apart = wrap_angle(place.match.target_T_source.yaw - match.target_T_source.yaw);
    return std::abs(apart) >= kFrontEndRejoin.elsewhere_rad && is_rival(place);
  };
  const bool is_likely = likeliest->explains ||
                         (!reach.is_carried && likeliest->value >= kFrontEndRejoin.likely_value);
  return {.match = in_local(match),
          .value = likeliest->value,
          .explains = likeliest->explains,
          .is_likely = is_likely,
          .faces_certainly = is_likely && std::ranges::none_of(places, faces_elsewhere),
          .is_only = is_likely && is_tight && std::ranges::none_of(places, is_rival)};
}

/// With odometry, a scan that does not fit where it says shows a place that the submap does not
/// know: one scan by itself is no reason to look for the robot elsewhere. Unless odometry says that
/// the robot stayed where all that it sees had been seen.
FrontEnd::Seen FrontEnd::rejoin(std::span<const SurfacePoint> surfaces, BlindMotion blind,
                                Stamp stamp, TrackedScan& tracked) {
  std::optional<MatchResult> match;
  BreakCause cause = BreakCause::kNoScans;
  if (blind.prior.holds_unobserved) {
    const PosePrior2 there = in_submap(blind.prior);
    const MatchResult near = match_at(surfaces, there);
    if (rested(blind, stamp) && fits_along(near, there))
      return begin_along(in_local(near), blind, stamp, tracked);
    match = recognise_near(surfaces, near, there);
    if (!match && was_carried(surfaces, blind, stamp)) {
      cause = BreakCause::kCarried;
      match = find_carried(surfaces, stamp, blind.prior);
    } else if (!match && fits_along(near, there)) {
      blind.prior = led_along(in_local(near), blind.prior);
    }
  } else if (blind.reach) {
    const Ahead ahead = look_ahead(surfaces, *blind.reach, blind.prior);
    if (ahead.is_certain()) {
      match = ahead.match;
    } else {
      turn_to_match(surfaces, ahead, *blind.reach, blind.prior);
    }
  } else {
    match = recognise_around(surfaces, blind.prior);
  }
  if (!match) {
    begin_piece(blind, cause, stamp, tracked);
    return {};
  }
  own_.lost_in_a_row = 0;
  const Seen seen = take_match(*match, true, tracked);
  note_gap(blind, cause, stamp, tracked);
  return seen;
}

UntoldReach FrontEnd::carried_from(const Pose2& local_T_robot, Stamp stamp) const {
  const double gap_s = (stamp - own_.held->stamp).seconds();
  const double walked_m = kMotionPredictor.walking_m_s * gap_s / kFrontEndRejoin.window_sigmas;
  const double sigma_m =
      std::min(std::max(kFrontEndRejoin.carried_m, walked_m), kFrontEndRejoin.unknown_m);
  // A gyro feels hands, too.
  const double sigma_rad =
      predictor_.heading_is_steady() ? kFrontEndRejoin.turned_rad : kFrontEndRejoin.unknown_rad;
  return {.frame_T_start = local_T_robot,
          .half_xy_m = window_of(sigma_m),
          .half_yaw_rad = window_of(sigma_rad),
          .sigma_m = sigma_m,
          .sigma_rad = sigma_rad,
          .is_carried = true};
}

/// Farther off one scan that fits is a likeness of places, and rooms are alike: what is seen from
/// there on has to be recognised.
std::optional<MatchResult> FrontEnd::find_carried(std::span<const SurfacePoint> surfaces,
                                                  Stamp stamp, PosePrior2& prior) const {
  const Pose2 before = prior.target_T_source;
  const UntoldReach reach = carried_from(before, stamp);
  prior = expected_at(before, reach, reach.sigma_rad);
  const Ahead ahead = look_ahead(surfaces, reach, prior);
  if (!ahead.explains) return {};
  const Pose2& there = ahead.match->target_T_source;
  const bool is_near =
      (there.translation() - before.translation()).norm() < kFrontEndRejoin.elsewhere_m;
  if (is_near && ahead.is_certain() && ahead.value >= least_score()) return ahead.match;
  prior = expected_at(there, reach,
                      ahead.faces_certainly ? std::min(kFrontEndRejoin.turned_rad, reach.sigma_rad)
                                            : reach.sigma_rad);
  return {};
}

/// The scan contradicts the submap where odometry says that the robot hardly moved; where it says
/// that it stood for long, it is enough that the scan does not fit.
bool FrontEnd::was_carried(std::span<const SurfacePoint> surfaces, const BlindMotion& blind,
                           Stamp stamp) const {
  if (!stood(blind)) return false;
  if (rested(blind, stamp) && blind.odometry_rad <= kFrontEndRejoin.short_rad) return true;
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
/// expected explains the scan, the robot most likely went on as it came; else it may be where what
/// the scan shows of the known fits.
void FrontEnd::turn_to_match(std::span<const SurfacePoint> surfaces, const Ahead& ahead,
                             const UntoldReach& reach, PosePrior2& prior) const {
  const MatchResult match = match_at(surfaces, in_submap(prior));
  const bool goes_on = has_supported_pose(match.status) && match.score >= least_score();
  if (!goes_on && !ahead.is_likely) return;
  if (!goes_on && ahead.is_only) {
    prior = {ahead.match->target_T_source,
             planar_covariance(kFrontEndRejoin.found_m, kFrontEndRejoin.faced_rad).inverse(),
             false};
    return;
  }
  const Pose2 likeliest = goes_on ? in_local(match).target_T_source : ahead.match->target_T_source;
  const bool faces_so = ahead.faces_certainly &&
                        std::abs(wrap_angle(ahead.match->target_T_source.yaw - likeliest.yaw)) <
                            kFrontEndRejoin.elsewhere_rad;
  if (goes_on && faces_so) {
    if (const auto along = gone_along(in_local(match).covariance, reach.sigma_m)) {
      prior = {likeliest, along->inverse(), false};
      return;
    }
  }
  prior = expected_at(
      likeliest, reach,
      std::min(faces_so ? kFrontEndRejoin.faced_rad : kFrontEndRejoin.turned_rad, reach.sigma_rad));
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

bool FrontEnd::stood(const BlindMotion& blind) const {
  return options_.odometry != OdometryUse::kTrust && blind.prior.holds_unobserved &&
         blind.odometry_m <= kFrontEndRejoin.short_m;
}

bool FrontEnd::rested(const BlindMotion& blind, Stamp stamp) const {
  return stood(blind) && (stamp - own_.held->stamp).seconds() >= kFrontEndRejoin.carried_s;
}

FrontEnd::Seen FrontEnd::begin_along(const MatchResult& match, BlindMotion blind, Stamp stamp,
                                     TrackedScan& tracked) {
  blind.prior.target_T_source = match.target_T_source;
  blind.prior.information = carried_along(match.covariance, Eigen::Vector2d::Zero()).inverse();
  begin_piece(blind, BreakCause::kNoScans, stamp, tracked);
  return {};
}

/// Where the scan tells the place it says how far the robot was carried; else that remains open.
FrontEnd::Seen FrontEnd::set_down(const Lift& lift, Sighting& sighting, TrackedScan& tracked) {
  const Seen seen = follow(sighting, tracked);
  if (own_.lost_in_a_row > 0) return seen;
  const Stamp stamp = sighting.scan->stamp;
  const Eigen::Vector2d way =
      tracked.local_T_robot.translation() - predictor_.lift().state().local_T_robot.translation();
  BlindMotion blind{
      {tracked.local_T_robot, carried_along(tracked.covariance, way).inverse(), false}};
  if (seen.translation) {
    note_gap(blind, BreakCause::kLifted, stamp, tracked);
  } else {
    begin_piece(blind, BreakCause::kLifted, stamp, tracked);
  }
  tracked.path_break->from = lift.from;
  return seen;
}

void FrontEnd::note_gap(const BlindMotion& blind, BreakCause cause, Stamp stamp,
                        TrackedScan& tracked) const {
  if (own_.lost_in_a_row > 0) return;
  tracked.path_break = PathBreak{.from = own_.held->stamp,
                                 .to = stamp,
                                 .cause = cause,
                                 .bridge = BreakBridge::kLaser,
                                 .odometry_m = blind.odometry_m,
                                 .covariance = blind.prior.information.inverse()};
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

std::optional<PathBreak> FrontEnd::break_in_the_end(
    Stamp last, const std::optional<OdometryReading>& odometry) const {
  if (!own_.held || (last - own_.held->stamp).seconds() <= longest_step_s()) return {};
  MotionGuess guess;
  guess.local_T_robot = predictor_.last_pose();
  const BlindMotion blind = blind_motion(last, guess, odometry);
  return PathBreak{
      .from = own_.held->stamp,
      .to = last,
      .cause = own_.lost_in_a_row > 0 ? BreakCause::kContradicted : BreakCause::kNoScans,
      .bridge = blind.prior.holds_unobserved ? BreakBridge::kOdometry : BreakBridge::kNothing,
      .odometry_m = blind.odometry_m,
      .ends_log = true,
      .covariance = blind.prior.information.inverse()};
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
