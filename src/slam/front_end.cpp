#include "loopstone/slam/front_end.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "geometry/symmetric_matrix.hpp"
#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/base/sound_state.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/rigid_motion.hpp"
#include "loopstone/registration/correlative_search.hpp"
#include "slam/front_end_numbers.hpp"
#include "slam/pose_search.hpp"

namespace loopstone {

namespace {

/// What stands farther off than who goes with the robot.
std::vector<SurfacePoint> beyond_company(std::span<const SurfacePoint> surfaces) {
  std::vector<SurfacePoint> beyond;
  std::ranges::copy_if(surfaces, std::back_inserter(beyond), [](const SurfacePoint& surface) {
    return surface.position.norm() > kLaserCheck.stranger_m;
  });
  return beyond;
}

/// Open submaps: the one that scans are aligned to, and the one that comes after it.
constexpr std::size_t kMostActive = 2;

/// What speaks for a match: how much of the scan it explains, less how far it is from the nearest
/// guess.
double merit(const MatchResult& match, std::span<const PosePrior2> priors) {
  if (match.status == MatchStatus::kTooFewPairs) return -1.0;
  double nearest = kFrontEnd.most_chi2;
  for (const PosePrior2& prior : priors) nearest = std::min(nearest, chi2_from(prior, match));
  return match.score - kFrontEnd.score_per_chi2 * nearest;
}

/// Whether two differ by more than both admit. \param freed  by a match that the guess did not hold
bool contradict(const PosePrior2& guess, const MatchResult& freed) {
  const Eigen::Vector3d apart =
      RigidMotion<2>::difference(freed.target_T_source, guess.target_T_source);
  const Eigen::Matrix3d covariance = guess.information.inverse() + freed.covariance;
  return apart.dot(covariance.inverse() * apart) > kFrontEnd.most_guess_chi2;
}

/// What a guess that was wrong still says: little, but all of it along what the laser leaves open,
/// as a corridor does. There a match that nothing holds slides to the next place that looks alike.
/// \param match  by this guess
Eigen::Matrix3d outvoted(const Eigen::Matrix3d& information, const MatchResult& match) {
  const Eigen::DiagonalMatrix<double, 3> scale(information.diagonal().cwiseSqrt());
  const Eigen::Matrix3d told =
      scale.inverse() * (match.covariance.inverse() - information) * scale.inverse();
  const SymmetricEigen<double, 3> axes = symmetric_eigen<double, 3>(told);
  if (axes.values[0] > kFrontEnd.tells_nothing) return information * kFrontEnd.outvoted;
  Eigen::Vector3d kept;
  for (int i = 0; i < 3; ++i)
    kept[i] = axes.values[i] > kFrontEnd.tells_nothing ? kFrontEnd.outvoted : 1.0;
  return scale * (axes.vectors * kept.asDiagonal() * axes.vectors.transpose()) * scale;
}

/// Whether a velocity that is wrong by so much bends a sweep.
bool bends(const LaserScan& scan, const Tangent2& velocity_error) {
  const double sweep_s = std::abs(sweep_seconds(scan));
  return velocity_error.head<2>().norm() * sweep_s > kFrontEnd.bend_m ||
         std::abs(velocity_error.z()) * sweep_s > kFrontEnd.bend_rad;
}

}  // namespace

FrontEnd::FrontEnd(const FrontEndOptions& options, const GridMatchOptions& match,
                   const SubmapOptions& submap, double odometry_scale)
    : options_(options),
      match_options_(match),
      submap_options_(submap),
      odometry_scale_(odometry_scale),
      predictor_(options.odometry != OdometryUse::kTrust, odometry_scale) {}

TrackedScan FrontEnd::add(const LaserScan& scan, const Pose2& robot_T_lidar,
                          std::optional<OdometryReading> odometry) {
  if (options_.odometry == OdometryUse::kIgnore) odometry.reset();
  Sighting sighting = prepare(scan, robot_T_lidar, odometry);
  TrackedScan tracked = predicted(sighting);
  const Seen seen = place(sighting, tracked);
  if (own_.lost_in_a_row > kFrontEnd.most_lost) give_up_or_ride(sighting, tracked);

  predictor_.settle(scan.stamp, tracked.local_T_robot, odometry, seen);
  tracked.left_out = own_.lost_in_a_row > 0;
  tracked.tracking = tracking_of(tracked, sighting.likeliest().measured, scan.stamp);
  if (tracked.used && !tracked.left_out) keep(sighting, tracked, seen);
  remember(sighting, tracked);
  remember_ground(scan, sighting, tracked);
  return tracked;
}

/// What is known of a scan before it is aligned.
FrontEnd::Sighting FrontEnd::prepare(const LaserScan& scan, const Pose2& robot_T_lidar,
                                     const std::optional<OdometryReading>& odometry) {
  std::vector<MotionGuess> guesses = predictor_.guesses(scan.stamp, odometry);
  LaserCover cover = cover_of(scan, robot_T_lidar, guesses);
  Sighting sighting{&scan, robot_T_lidar, odometry, std::move(guesses)};
  sighting.cover = std::move(cover);
  sighting.whole = &scan;
  show_rest(scan, sighting);
  take_out_travelling(scan, sighting);
  sighting.believed = laser_check_.add(scan, odometry, sighting.cover.is_fault);
  sighting.own_count = sighting.surfaces.size();
  add_companions(sighting);
  return sighting;
}

/// Where odometry may have jumped, a scan that fits any of the guesses shows no strangers.
LaserCover FrontEnd::cover_of(const LaserScan& scan, const Pose2& robot_T_lidar,
                              std::span<const MotionGuess> guesses) {
  if (active_.empty()) return {};
  const ActiveSubmap& known = active_.front();
  const Pose2 submap_T_local = known.local_T_submap.inverse();
  const bool is_measured = guesses.front().measured;
  LaserCover least;
  for (const MotionGuess& guess : guesses) {
    const Pose2 submap_T_lidar = submap_T_local * guess.local_T_robot * robot_T_lidar;
    LaserCover cover = loopstone::cover_of(scan, submap_T_lidar, is_measured, known.submap, beams_);
    if (cover.beams.empty()) return cover;
    if (least.beams.empty() ||
        std::ranges::count(cover.beams, true) < std::ranges::count(least.beams, true)) {
      least = std::move(cover);
    }
  }
  return least;
}

/// What is left of a scan without the beams that do not show the surroundings.
void FrontEnd::show_rest(const LaserScan& scan, Sighting& sighting) {
  const LaserScan* shown = &scan;
  if (!sighting.cover.beams.empty()) {
    uncovered_ = scan;
    take_out(sighting.cover.beams, uncovered_);
    shown = &uncovered_;
  }
  sighting.scan = shown;
  sighting.surfaces = surfaces_of(*shown, sighting.robot_T_lidar,
                                  velocity_to(sighting.likeliest().local_T_robot, *shown));
}

/// Odometry says what moves once it has proved itself, or where the laser never found it wrong.
bool FrontEnd::odometry_may_lead() const {
  if (options_.odometry == OdometryUse::kTrust) return true;
  const MotionAgreement& agreement = predictor_.check().translation();
  return agreement.scale().has_value() ||
         std::ranges::none_of(agreement.state().pieces,
                              [](const MotionAgreement::Piece& piece) { return piece.wrong; });
}

/// People stand about the robot, or did a moment ago: who goes with it is not always told.
bool FrontEnd::is_crowded(const LaserScan& scan) const {
  return std::ranges::any_of(laser_check_.episodes(), [&](const LaserEpisode& episode) {
    return episode.fault == LaserFault::kCovered && episode.lidar == scan.lidar &&
           (scan.stamp - episode.to).seconds() < kFrontEnd.crowd_rest_s;
  });
}

/// What moves against the ground, where the robot could be held by little else. Past a robot that
/// stands, perhaps in somebody's hands, the ground itself may travel.
void FrontEnd::take_out_travelling(const LaserScan& scan, Sighting& sighting) {
  const MotionGuess& guess = sighting.likeliest();
  const bool is_likely = sighting.guesses.size() == 1;  // it may have jumped
  if (!guess.measured || !is_likely || !sighting.odometry || !odometry_may_lead() ||
      !is_said_to_drive(sighting))
    return;
  sighting.is_crowded = is_crowded(scan);
  if (sighting.is_crowded) {
    const auto beyond = beyond_company(sighting.surfaces);
    sighting.is_led = leave_open(beyond);
    if (sighting.is_led) sighting.led_along = weakest_axis(beyond);
  }
  Pose2 ground_T_robot = guess.local_T_robot;
  ground_T_robot.x += own_.local_to_ground_m.x();
  ground_T_robot.y += own_.local_to_ground_m.y();
  const std::vector<bool> found =
      travelling_.find(scan, ground_T_robot * sighting.robot_T_lidar, sighting.odometry->path_m,
                       sighting.cover.beams, beams_);
  if (found.empty()) return;
  const std::vector<bool> covered = sighting.cover.beams;
  sighting.cover.beams.resize(found.size(), false);
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i]) sighting.cover.beams[i] = true;
  }
  show_rest(scan, sighting);
  if (leave_open(sighting.surfaces)) {
    // Where odometry has proved itself, what contradicts it is contested: see contest().
    const bool is_proved = predictor_.check().translation().scale().has_value();
    if (!is_proved && is_crowd(sighting.cover.beams)) sighting.cover.is_fault = true;
    sighting.is_led = true;
    return;
  }
  sighting.cover.beams = covered;
  show_rest(scan, sighting);
}

/// By the laser's heading, which is the better one, and odometry's motion.
void FrontEnd::remember_ground(const LaserScan& scan, const Sighting& sighting,
                               const TrackedScan& tracked) {
  const auto jumped = [&](const MotionAgreement& agreement) {
    return agreement.state().last_jump == scan.stamp;
  };
  const OdometryCheck& check = predictor_.check();
  // What a heading that slips tells of scans that nobody placed is hearsay.
  const bool is_placed =
      !tracked.left_out || (sighting.is_driven && predictor_.heading_is_steady());
  const bool goes_on = sighting.likeliest().measured && sighting.odometry && sighting.believed &&
                       is_placed && !tracked.path_break && !jumped(check.translation()) &&
                       !jumped(check.rotation());
  if (!goes_on) {
    travelling_.forget();
    own_.local_to_ground_m.setZero();
    return;
  }
  own_.local_to_ground_m +=
      sighting.likeliest().local_T_robot.translation() - tracked.local_T_robot.translation();
  Pose2 ground_T_robot = tracked.local_T_robot;
  ground_T_robot.x += own_.local_to_ground_m.x();
  ground_T_robot.y += own_.local_to_ground_m.y();
  travelling_.remember(scan, ground_T_robot * sighting.robot_T_lidar, sighting.odometry->path_m);
}

void FrontEnd::add_companions(Sighting& sighting) const {
  const LaserView* const own = view_of(sighting.scan->lidar);
  const bool is_mapped = own != nullptr && own->piece == own_.piece;
  const float trust = sighting.likeliest().measured ? 1.0F : kFrontEnd.companion_guess;
  for (const LaserView& view : views_) {
    const double age_s = (sighting.scan->stamp - view.stamp).seconds();
    if (view.lidar == sighting.scan->lidar || std::abs(age_s) > kFrontEnd.companion_s) continue;
    const Pose2 now_T_then = sighting.likeliest().local_T_robot.inverse() * view.local_T_robot;
    const Eigen::Matrix2f rotation = now_T_then.rotation().cast<float>();
    const Eigen::Vector2f translation = now_T_then.translation().cast<float>();
    for (const SurfacePoint& seen : view.surfaces) {
      sighting.surfaces.push_back(
          {rotation * seen.position + translation, rotation * seen.normal, trust * seen.weight});
    }
    sighting.is_new_laser = !is_mapped && !active_.empty();
  }
}

/// What this laser saw helps the others.
void FrontEnd::remember(const Sighting& sighting, const TrackedScan& tracked) {
  const int lidar = sighting.scan->lidar;
  auto view = std::ranges::find(views_, lidar, &LaserView::lidar);
  const bool is_known = view != views_.end();
  if (!is_known && !tracked.key) return;
  if (!is_known) view = views_.insert(views_.end(), {.lidar = lidar});
  view->stamp = sighting.scan->stamp;
  view->local_T_robot = tracked.local_T_robot;
  const bool helps = tracked.used && !tracked.left_out;
  view->surfaces.assign(sighting.own().begin(),
                        helps ? sighting.own().end() : sighting.own().begin());
  if (!tracked.key) return;
  view->piece = own_.piece;
  view->last_key = tracked.local_T_robot;
}

const LaserView* FrontEnd::view_of(int lidar) const {
  const auto view = std::ranges::find(views_, lidar, &LaserView::lidar);
  return view == views_.end() ? nullptr : &*view;
}

/// The scan where it was expected, before the laser is asked.
TrackedScan FrontEnd::predicted(const Sighting& sighting) {
  const MotionGuess& guess = sighting.likeliest();
  TrackedScan tracked;
  tracked.local_T_robot = tracked.guess_local_T_robot = guess.local_T_robot;
  tracked.taken_out = sighting.cover.beams;
  tracked.used = sighting.believed &&
                 sighting.matched().size() >= static_cast<std::size_t>(kFrontEnd.min_points);
  if (!tracked.used) tracked.covariance = guess.information.inverse();
  return tracked;
}

/// Where the scan was taken, as far as the laser can tell.
FrontEnd::Seen FrontEnd::place(Sighting& sighting, TrackedScan& tracked) {
  if (!tracked.used) return {};
  if (active_.empty()) {  // it is the first of its piece, and says where that lies
    tracked.status = MatchStatus::kConverged;
    tracked.score = 1.0;
    return {true, true};
  }
  const Stamp stamp = sighting.scan->stamp;
  const auto blind = [&] { return blind_motion(stamp, sighting.likeliest(), sighting.odometry); };
  if (is_gap(stamp)) {
    const BlindMotion motion = blind();
    if (rested(motion, stamp) || !motion.is_short())
      return rejoin(sighting.matched(), motion, stamp, tracked);
  }
  const auto lift =
      sighting.odometry ? predictor_.lift().ended_by(*sighting.odometry) : std::optional<Lift>{};
  if (lift && lift->unseen_s > kLiftWatch.unseen_s) return set_down(*lift, sighting, tracked);
  const Stamp before = *predictor_.last_stamp();
  const Seen seen = follow(sighting, tracked);
  // A short gap, but nothing told of it, and the scan does not fit where the robot was expected.
  const bool is_untold = own_.held && own_.lost_in_a_row == 1 && !sighting.likeliest().measured &&
                         (stamp - before).seconds() > kFrontEnd.skipped * own_.held->usual_seconds;
  if (is_untold) {
    MotionGuess expected = sighting.likeliest();
    expected.local_T_robot = tracked.local_T_robot;
    const BlindMotion motion = blind_motion(stamp, expected, sighting.odometry);
    if (motion.reach) return rejoin(sighting.matched(), motion, stamp, tracked);
  }
  if (is_gap(stamp)) note_gap(blind(), BreakCause::kNoScans, stamp, tracked);  // also of one lost
  return seen;
}

/// The scan of a robot that was seen a moment ago.
FrontEnd::Seen FrontEnd::follow(Sighting& sighting, TrackedScan& tracked) {
  const LaserScan& scan = *sighting.whole;
  const MotionGuess& guess = sighting.likeliest();
  MotionGuess led = guess;
  if (sighting.is_crowded) led.information *= kFrontEnd.led;
  if (sighting.led_along) {
    const Eigen::Vector2d along = guess.local_T_robot.rotation() * *sighting.led_along;
    led.information.topLeftCorner<2, 2>() +=
        along * along.transpose() / (kFrontEnd.led_along_m * kFrontEnd.led_along_m);
  }
  Alignment alignment = sighting.is_led ? align(sighting.matched(), std::span(&led, 1), {}, false)
                                        : align(sighting.matched(), sighting.guesses,
                                                others_than_odometry(scan.stamp), true);
  sighting.is_driven = is_driven(sighting);
  const bool is_decided = sighting.is_driven && !is_believed(alignment, sighting);
  if (is_decided) alignment = contest(sighting);
  Tangent2 velocity = velocity_to(guess.local_T_robot, scan);
  for (int pass = 0; pass < kFrontEnd.straightenings && !alignment.lost && !is_decided; ++pass) {
    // A scan that was straightened by a wrong velocity is straightened anew.
    if (!has_supported_pose(alignment.match.status)) break;
    const Tangent2 matched = velocity_to(alignment.match.target_T_source, scan);
    if (!bends(scan, matched - velocity)) break;
    velocity = matched;
    straighten(sighting, velocity);
    MotionGuess again = sighting.is_led ? led : guess;
    if (alignment.overruled || !guess.measured) {
      again.local_T_robot = alignment.match.target_T_source;
      again.information = outvoted(guess.information, alignment.match);
    }
    alignment.match = align(sighting.matched(), std::span(&again, 1), {}, !sighting.is_led).match;
  }
  tracked.searched = alignment.searched;
  tracked.taken_out = sighting.cover.beams;
  own_.lost_in_a_row = alignment.lost ? own_.lost_in_a_row + 1 : 0;
  const Seen seen = take_match(alignment.match, !alignment.lost, tracked);
  if (sighting.is_led) return {};  // it is no witness against what leads it
  // Who goes along with the robot says that it stands.
  return {seen.translation && !sighting.is_crowded, seen.rotation};
}

/// Too many scans in a row contradict the map. While wheels turn nobody carries the robot, so it is
/// the laser that shows something else (the floor, where the robot leans): odometry goes on in the
/// same map. What is still contradicted after some way is a place of its own.
void FrontEnd::give_up_or_ride(const Sighting& sighting, TrackedScan& tracked) {
  const Stamp stamp = sighting.scan->stamp;
  const BlindMotion told = blind_motion(stamp, sighting.likeliest(), sighting.odometry);
  const bool drove = told.prior.holds_unobserved && told.odometry_m >= kFrontEndRejoin.drove_m;
  if (drove && told.odometry_m <= kFrontEndRejoin.ride_m) {
    own_.lost_in_a_row = kFrontEnd.most_lost;  // one more will ask again
    return;
  }
  // They came after a gap in which odometry says that the robot stood.
  const double blind_s =
      (stamp - own_.held->stamp).seconds() - own_.lost_in_a_row * own_.held->usual_seconds;
  if (drove || !told.prior.holds_unobserved || blind_s <= longest_step_s()) {
    begin_piece(drove ? told : blind_motion(stamp, sighting.likeliest(), {}),
                BreakCause::kContradicted, stamp, tracked);
    return;
  }
  // It was carried meanwhile, and is looked for all around.
  BlindMotion carried = told;
  const auto match = find_carried(sighting.matched(), stamp, carried.prior);
  if (!match) {
    begin_piece(carried, BreakCause::kCarried, stamp, tracked);
    return;
  }
  own_.lost_in_a_row = 0;
  (void)take_match(*match, true, tracked);
  note_gap(carried, BreakCause::kCarried, stamp, tracked);
}

/// A scan whose pose holds: the next one goes on from it, and the submaps may take it in.
void FrontEnd::keep(const Sighting& sighting, TrackedScan& tracked, Seen seen) {
  hold(sighting.scan->stamp, tracked.local_T_robot, sighting.odometry);
  if (predictor_.lift().is_lifted() && !seen.translation) return;
  if (active_.empty() || moved_enough(sighting.scan->lidar, tracked.local_T_robot)) {
    insert(sighting, tracked);
  }
}

/// What a match says of its scan. \param is_held  the laser holds the pose
FrontEnd::Seen FrontEnd::take_match(const MatchResult& match, bool is_held, TrackedScan& tracked) {
  tracked.local_T_robot = match.target_T_source;
  tracked.covariance = match.covariance;
  tracked.status = match.status;
  tracked.score = match.score;
  const bool fits =
      is_held && match.status != MatchStatus::kTooFewPairs && match.score >= options_.trusted_score;
  if (fits) own_.usual_score += (match.score - own_.usual_score) / kFrontEnd.score_memory;
  return {fits && match.status != MatchStatus::kDegenerate, fits};
}

/// Its own beams, by a better velocity.
void FrontEnd::straighten(Sighting& sighting, const Tangent2& velocity) {
  std::vector<SurfacePoint> surfaces =
      surfaces_of(*sighting.scan, sighting.robot_T_lidar, velocity);
  const std::size_t own_count = surfaces.size();
  const auto others = std::span(sighting.surfaces).subspan(sighting.own_count);
  surfaces.insert(surfaces.end(), others.begin(), others.end());
  sighting.surfaces = std::move(surfaces);
  sighting.own_count = own_count;
}

Tangent2 FrontEnd::velocity_to(const Pose2& local_T_robot, const LaserScan& scan) const {
  const auto& last = predictor_.last_stamp();
  if (!last || scan.stamp <= *last) return Tangent2::Zero();
  return log(predictor_.last_pose().inverse() * local_T_robot) / seconds_between_scans(*last, scan);
}

std::vector<SurfacePoint> FrontEnd::surfaces_of(const LaserScan& scan, const Pose2& robot_T_lidar,
                                                const Tangent2& velocity) {
  const SurfaceOptions surface_options{.range_max_m = options_.range_max_m,
                                       .points_max = options_.points_max};
  return surface_points(scan, robot_T_lidar, velocity, surface_options, beams_);
}

FrontEnd::Alignment FrontEnd::align(std::span<const SurfacePoint> surfaces,
                                    std::span<const MotionGuess> guesses,
                                    std::span<const MotionGuess> others, bool may_outvote) const {
  const auto& grid = active_.front().submap.surfaces();
  std::vector<PosePrior2> priors;
  Alignment result;
  MatchResult best;
  std::size_t best_prior = 0;
  const auto try_guess = [&](const MotionGuess& guess) {
    priors.push_back(in_submap({guess.local_T_robot, guess.information, guess.measured}));
    const PosePrior2& prior = priors.back();
    const MatchResult match =
        match_to_grid(surfaces, grid, prior.target_T_source, prior, match_options_, 1);
    if (priors.size() > 1 && merit(match, priors) <= merit(best, priors)) return;
    best = match;
    best_prior = priors.size() - 1;
  };
  for (const MotionGuess& guess : guesses) try_guess(guess);
  // Odometry that explains less than usual is not the only way that the robot may have gone.
  if (guesses.front().measured && merit(best, priors) < own_.usual_score - kFrontEnd.score_drop) {
    for (const MotionGuess& guess : others) try_guess(guess);
  }
  result.overruled = best_prior != 0;
  // Where the laser pulls far away from the guess, the guess was wrong and must not pull back.
  if (may_outvote && has_supported_pose(best.status) &&
      chi2_from(priors[best_prior], best) > kFrontEnd.most_guess_chi2) {
    PosePrior2 loose = priors[best_prior];
    loose.information = outvoted(loose.information, best);
    const MatchResult freed =
        match_to_grid(surfaces, grid, best.target_T_source, loose, match_options_, 0);
    if (has_supported_pose(freed.status) && freed.score >= best.score - kFrontEnd.same_score &&
        contradict(priors[best_prior], freed)) {
      best = freed;
      result.overruled = true;
    }
  }

  const double least = priors.front().holds_unobserved ? options_.trusted_score : least_score();
  if (best.status == MatchStatus::kTooFewPairs || best.score < least) {
    const Searched searched = search(surfaces, priors, best);
    best = searched.match;
    result.searched = result.overruled = true;
    result.lost = searched.lost;
  }
  if (result.lost || best.status == MatchStatus::kTooFewPairs) {
    best.target_T_source = priors[best_prior].target_T_source;
    best.covariance = priors[best_prior].information.inverse();
    if (result.lost) best.status = MatchStatus::kNotConverged;
  }
  result.match = in_local(best);
  return result;
}

FrontEnd::Searched FrontEnd::search(std::span<const SurfacePoint> surfaces,
                                    std::span<const PosePrior2> priors,
                                    const MatchResult& matched) const {
  const ActiveSubmap& target = active_.front();
  const PosePrior2& likeliest = priors.front();
  const FrozenSubmap frozen = target.submap.freeze();
  const auto points = search_points(surfaces);
  const auto best_of = [&](const MatchResult& best, const MaxPyramid& pyramid,
                           const SearchWindow& window, double least_score) {
    const auto found = search_about_robot(points, pyramid, window, kPoseSearch.min_score);
    if (!found.found) return best;
    const PosePrior2 loose{found.target_T_source, likeliest.information * kFrontEnd.outvoted,
                           likeliest.holds_unobserved};
    const MatchResult other = match_to_grid(surfaces, target.submap.surfaces(),
                                            found.target_T_source, loose, match_options_, 0);
    const Pose2 off = window.centre.inverse() * other.target_T_source;
    const bool inside = std::max(std::abs(off.x), std::abs(off.y)) <= window.half_xy_m;
    return inside && other.score >= least_score && merit(other, priors) > merit(best, priors)
               ? other
               : best;
  };

  SearchWindow window{likeliest.target_T_source, options_.search_half_xy_m,
                      options_.search_half_yaw_rad};
  if (!likeliest.holds_unobserved) {
    // Without odometry the robot may have turned back as well as gone on: what counts is where it
    // was.
    window.centre = target.local_T_submap.inverse() * predictor_.last_pose();
    window.half_xy_m *= kFrontEnd.free_window;
    window.half_yaw_rad *= kFrontEnd.free_window;
  }
  const MaxPyramid pyramid = frozen.search_pyramid(submap_options_, window.half_xy_m);
  Searched result{best_of(matched, pyramid, window, 0.0), false};
  const auto is_lost = [&] {
    return result.match.status == MatchStatus::kTooFewPairs ||
           (result.match.score < options_.trusted_score &&
            agreement_at(points, pyramid, result.match.target_T_source) < kPoseSearch.min_score);
  };
  if (!is_lost()) return result;
  if (is_unfamiliar(points, pyramid, likeliest)) {
    result.match.status = MatchStatus::kTooFewPairs;
    return result;
  }
  // It contradicts what was seen before: scans are missing, or the robot was carried. It may face
  // anywhere; among so many poses only one that explains what scans usually explain is no chance.
  const SearchWindow anywhere{likeliest.target_T_source,
                              std::max(kFrontEnd.lost_m, window.half_xy_m), kPi};
  result.match = best_of(result.match, frozen.search_pyramid(submap_options_, anywhere.half_xy_m),
                         anywhere, least_score());
  result.lost = is_lost();
  return result;
}

bool FrontEnd::is_unfamiliar(std::span<const Eigen::Vector2d> points, const MaxPyramid& known,
                             const PosePrior2& prior) const {
  // What comes after much that contradicts belongs to it.
  if (!prior.holds_unobserved || own_.lost_in_a_row >= kFrontEnd.most_lost) return false;
  const Pose2 motion =
      predictor_.last_pose().inverse() * active_.front().local_T_submap * prior.target_T_source;
  if (motion.translation().norm() > options_.submap_length_m) return false;
  // A robot that was carried stands, as odometry has it.
  if (motion.translation().norm() < kFrontEnd.drives_m &&
      std::abs(motion.yaw) < kFrontEnd.turns_rad)
    return false;
  const auto contradicts = [&](const Eigen::Vector2d& point) {
    const Cell cell = known.frame().cell_of(prior.target_T_source * point);
    return known.bound(0, cell.column, cell.row) < kUnknown;
  };
  return static_cast<double>(std::ranges::count_if(points, contradicts)) <=
         kFrontEnd.contradicted_share * static_cast<double>(points.size());
}

double FrontEnd::least_score() const {
  return std::max(options_.trusted_score, own_.usual_score - kFrontEnd.score_drop);
}

bool FrontEnd::moved_enough(int lidar, const Pose2& local_T_robot) const {
  const LaserView* const view = view_of(lidar);
  if (view == nullptr || view->piece != own_.piece) return true;
  const Pose2& last = view->last_key;
  return hypotenuse(local_T_robot.x - last.x, local_T_robot.y - last.y) >=
             options_.key_distance_m ||
         std::abs(wrap_angle(local_T_robot.yaw - last.yaw)) >= options_.key_angle_rad;
}

void FrontEnd::insert(const Sighting& sighting, TrackedScan& tracked) {
  const double step = hypotenuse(tracked.local_T_robot.x - own_.last_key.x,
                                 tracked.local_T_robot.y - own_.last_key.y);
  for (auto& active : active_) active.travelled_m += step;
  const bool start_next =
      active_.empty() || active_.back().travelled_m >= 0.5 * options_.submap_length_m;
  if (start_next) {
    if (active_.size() == kMostActive) {
      tracked.finished.push_back({active_.front().submap.freeze(), active_.front().first_key,
                                  own_.key_count - 1, own_.piece});
      active_.erase(active_.begin());
    }
    active_.push_back({Submap(submap_options_), tracked.local_T_robot, own_.key_count, 0.0});
  }
  for (auto& active : active_) {
    active.submap.insert(sighting.own(), *sighting.scan, sighting.robot_T_lidar,
                         active.local_T_submap.inverse() * tracked.local_T_robot, beams_);
  }
  own_.last_key = tracked.local_T_robot;
  ++own_.key_count;
  tracked.key = true;
  tracked.starts_submap = start_next;
}

std::vector<FinishedSubmap> FrontEnd::end_piece() {
  std::vector<FinishedSubmap> finished;
  for (const auto& active : active_)
    finished.push_back({active.submap.freeze(), active.first_key, own_.key_count - 1, own_.piece});
  active_.clear();
  return finished;
}

std::vector<FinishedSubmap> FrontEnd::begin_drive() {
  std::vector<FinishedSubmap> finished = end_piece();
  predictor_ = MotionPredictor(options_.odometry != OdometryUse::kTrust, odometry_scale_);
  laser_check_ = {};
  travelling_ = {};
  views_.clear();
  own_ = {.key_count = own_.key_count, .piece = own_.piece + 1};
  return finished;
}

std::vector<FinishedSubmap> FrontEnd::finish() { return end_piece(); }

FrontEnd::State FrontEnd::state() const {
  State state{{}, predictor_.state(), laser_check_.state(), travelling_.state(), views_, own_};
  for (const ActiveSubmap& active : active_) {
    state.active.push_back(
        {active.submap.state(), active.local_T_submap, active.first_key, active.travelled_m});
  }
  return state;
}

void FrontEnd::restore(State state) {
  const State::Own& own = state.own;
  require_sound(state.active.size() <= kMostActive, "more open submaps than there can be");
  require_sound(own.held || (state.active.empty() && own.lost_in_a_row == 0),
                "a submap before the first scan");
  require_sound(own.lost_in_a_row >= 0 && own.lost_in_a_row <= kFrontEnd.most_lost,
                "more scans lost than are waited for");
  require_sound(std::isfinite(own.usual_score) && (!own.held || is_amount(own.held->usual_seconds)),
                "what is usual is no number");
  std::size_t keys = 0;  // that the submaps before have seen
  for (const State::Active& active : state.active) {
    require_sound(active.first_key >= keys && active.first_key < own.key_count,
                  "a submap of key scans that are not there");
    require_sound(is_amount(active.travelled_m), "a path without a length");
    keys = active.first_key + 1;
  }
  for (const LaserView& view : state.views) {
    require_sound(view.piece <= own.piece, "a laser that was mapped later than now");
    require_sound(view.local_T_robot.vector().allFinite() && view.last_key.vector().allFinite(),
                  "a laser's last pose is no number");
    require_sound(std::ranges::count(state.views, view.lidar, &LaserView::lidar) == 1,
                  "one laser twice");
  }
  active_.clear();
  for (State::Active& active : state.active) {
    active_.push_back(
        {Submap(submap_options_), active.local_T_submap, active.first_key, active.travelled_m});
    active_.back().submap.restore(std::move(active.submap));
  }
  predictor_.restore(std::move(state.predictor));
  laser_check_.restore(std::move(state.laser_check));
  travelling_.restore(std::move(state.travelling));
  views_ = std::move(state.views);
  own_ = state.own;
}

}  // namespace loopstone
