#include "loopstone/slam/front_end.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/registration/correlative_search.hpp"
#include "slam/pose_search.hpp"

namespace loopstone {

namespace {

/// A scan with fewer points says too little to be aligned or mapped.
constexpr std::size_t kMinPoints = 20;
/// Where a robot is looked for that was lost.
constexpr double kLostM = 2.0;
/// Scans in a row that contradict the map are left out of it; after so many the place itself must
/// have changed.
constexpr int kMostLost = 5;
/// How far a match may go against the guesses. A scan is worth about 50 independent points, and
/// that one is explained speaks for a match by ln(0.93 / 0.07) when one in fourteen never is: 50 *
/// 2.6 of log-likelihood against half a chi-square. Beyond 5 standard deviations the guess was an
/// error, however far.
constexpr double kScorePerChi2 = 0.004;
constexpr double kMostChi2 = 25.0;
/// A match farther from its guess than chance explains (chi-square, 3 degrees of freedom, 0.05)
/// shows that the guess was wrong; then it keeps this share of its weight.
constexpr double kMostGuessChi2 = 7.8;
constexpr double kOutvoted = 0.01;
/// Scores that differ by less say the same.
constexpr double kSameScore = 0.02;
/// A scan that explains so much less than usual is searched for, or shows another place.
constexpr double kScoreDrop = 0.1;
constexpr double kScoreMemory = 50.0;
/// ... and in a window that is so much wider.
constexpr double kFreeWindow = 2.0;
/// A sweep bent by more than this by a wrong velocity is straightened anew.
constexpr double kBendM = 0.01;
constexpr double kBendRad = 0.005;
/// Each pass takes away what the sweep is of the time between scans: half of the error or more.
constexpr int kStraightenings = 3;

/// What speaks for a match: how much of the scan it explains, less how far it is from the nearest
/// guess.
double merit(const MatchResult& match, std::span<const PosePrior2> priors) {
  if (match.status == MatchStatus::kTooFewPairs) return -1.0;
  double nearest = kMostChi2;
  for (const PosePrior2& prior : priors) nearest = std::min(nearest, chi2_from(prior, match));
  return match.score - kScorePerChi2 * nearest;
}

/// Whether a velocity that is wrong by so much bends a sweep.
bool bends(const LaserScan& scan, const Tangent2& velocity_error) {
  const double sweep_s = std::abs(sweep_seconds(scan));
  return velocity_error.head<2>().norm() * sweep_s > kBendM ||
         std::abs(velocity_error.z()) * sweep_s > kBendRad;
}

}  // namespace

FrontEnd::FrontEnd(const FrontEndOptions& options, const GridMatchOptions& match,
                   const SubmapOptions& submap)
    : options_(options),
      match_options_(match),
      submap_options_(submap),
      predictor_(options.odometry != "trust") {}

TrackedScan FrontEnd::add(const LaserScan& scan, const Pose2& robot_T_lidar,
                          std::optional<OdometryReading> odometry) {
  if (options_.odometry == "ignore") odometry.reset();
  TrackedScan tracked;
  const std::vector<MotionGuess> guesses = predictor_.guesses(scan.stamp, odometry);
  tracked.local_T_robot = tracked.guess_local_T_robot = guesses.front().local_T_robot;

  const bool believed = laser_check_.add(scan, odometry);
  auto surfaces =
      surfaces_of(scan, robot_T_lidar, velocity_to(guesses.front().local_T_robot, scan));
  tracked.used = believed && surfaces.size() >= kMinPoints;
  const auto blind = [&] { return blind_motion(scan.stamp, guesses.front(), odometry); };
  Seen seen;
  if (!tracked.used) {
    tracked.covariance = guesses.front().information.inverse();
  } else if (active_.empty()) {
    tracked.status = MatchStatus::kConverged;
    tracked.score = 1.0;
    seen = {true, true};
  } else if (is_gap(scan.stamp) && !blind().is_short()) {
    seen = rejoin(surfaces, blind(), scan.stamp, tracked);
  } else {
    seen = follow(scan, robot_T_lidar, guesses, surfaces, tracked);
    if (is_gap(scan.stamp)) note_gap(blind(), scan.stamp, tracked);
  }
  if (lost_in_a_row_ > kMostLost) {
    begin_piece(blind_motion(scan.stamp, guesses.front(), {}), BreakCause::kContradicted,
                scan.stamp, tracked);
  }

  predictor_.settle(scan.stamp, tracked.local_T_robot, odometry, seen);
  tracked.left_out = lost_in_a_row_ > 0;
  tracked.tracking = tracking_of(tracked, guesses.front().measured, scan.stamp);
  if (!tracked.used || tracked.left_out) return tracked;
  hold(scan.stamp, tracked.local_T_robot, odometry);
  if (active_.empty() || moved_enough(tracked.local_T_robot))
    insert(surfaces, scan, robot_T_lidar, tracked);
  return tracked;
}

/// The scan of a robot that was seen a moment ago.
FrontEnd::Seen FrontEnd::follow(const LaserScan& scan, const Pose2& robot_T_lidar,
                                std::span<const MotionGuess> guesses,
                                std::vector<SurfacePoint>& surfaces, TrackedScan& tracked) {
  Alignment alignment = align(surfaces, guesses, others_than_odometry(scan.stamp));
  Tangent2 velocity = velocity_to(guesses.front().local_T_robot, scan);
  for (int pass = 0; pass < kStraightenings && !alignment.lost; ++pass) {
    // A scan that was straightened by a wrong velocity is straightened anew.
    if (!has_supported_pose(alignment.match.status)) break;
    const Tangent2 matched = velocity_to(alignment.match.target_T_source, scan);
    if (!bends(scan, matched - velocity)) break;
    velocity = matched;
    surfaces = surfaces_of(scan, robot_T_lidar, velocity);
    MotionGuess again = guesses.front();
    again.local_T_robot = alignment.match.target_T_source;
    again.information *= kOutvoted;
    alignment.match = align(surfaces, std::span(&again, 1), {}).match;
  }
  tracked.searched = alignment.searched;
  lost_in_a_row_ = alignment.lost ? lost_in_a_row_ + 1 : 0;
  return take_match(alignment.match, !alignment.lost, tracked);
}

/// What a match says of its scan. \param is_held  the laser holds the pose
FrontEnd::Seen FrontEnd::take_match(const MatchResult& match, bool is_held, TrackedScan& tracked) {
  tracked.local_T_robot = match.target_T_source;
  tracked.covariance = match.covariance;
  tracked.status = match.status;
  tracked.score = match.score;
  const bool fits =
      is_held && match.status != MatchStatus::kTooFewPairs && match.score >= options_.trusted_score;
  if (fits) usual_score_ += (match.score - usual_score_) / kScoreMemory;
  return {fits && match.status != MatchStatus::kDegenerate, fits};
}

Tangent2 FrontEnd::velocity_to(const Pose2& local_T_robot, const LaserScan& scan) const {
  const auto& last = predictor_.last_stamp();
  if (!last || scan.stamp <= *last) return Tangent2::Zero();
  // No scanner begins its next sweep before the last one is over; stamps that say so are wrong.
  const double seconds = std::max((scan.stamp - *last).seconds(), std::abs(sweep_seconds(scan)));
  return log(predictor_.last_pose().inverse() * local_T_robot) / seconds;
}

std::vector<SurfacePoint> FrontEnd::surfaces_of(const LaserScan& scan, const Pose2& robot_T_lidar,
                                                const Tangent2& velocity) {
  const SurfaceOptions surface_options{.range_max_m = options_.range_max_m,
                                       .points_max = options_.points_max};
  return surface_points(scan, robot_T_lidar, velocity, surface_options, beams_);
}

FrontEnd::Alignment FrontEnd::align(std::span<const SurfacePoint> surfaces,
                                    std::span<const MotionGuess> guesses,
                                    std::span<const MotionGuess> others) const {
  const auto& grid = active_.front().submap.surfaces();
  std::vector<PosePrior2> priors;
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
  if (guesses.front().measured && merit(best, priors) < usual_score_ - kScoreDrop) {
    for (const MotionGuess& guess : others) try_guess(guess);
  }
  // Where the laser pulls far away from the guess, the guess was wrong and must not pull back.
  if (has_supported_pose(best.status) && chi2_from(priors[best_prior], best) > kMostGuessChi2) {
    PosePrior2 loose = priors[best_prior];
    loose.information *= kOutvoted;
    const MatchResult freed =
        match_to_grid(surfaces, grid, best.target_T_source, loose, match_options_, 0);
    if (has_supported_pose(freed.status) && freed.score >= best.score - kSameScore) best = freed;
  }

  Alignment result;
  const double least = priors.front().holds_unobserved ? options_.trusted_score : least_score();
  if (best.status == MatchStatus::kTooFewPairs || best.score < least) {
    const Searched searched = search(surfaces, priors, best);
    best = searched.match;
    result.searched = true;
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
    const auto found = search_about_robot(points, pyramid, window, kSearchMinScore);
    if (!found.found) return best;
    const PosePrior2 loose{found.target_T_source, likeliest.information * kOutvoted,
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
    window.half_xy_m *= kFreeWindow;
    window.half_yaw_rad *= kFreeWindow;
  }
  const MaxPyramid pyramid = frozen.search_pyramid(submap_options_, window.half_xy_m);
  Searched result{best_of(matched, pyramid, window, 0.0), false};
  const auto is_lost = [&] {
    return result.match.status == MatchStatus::kTooFewPairs ||
           (result.match.score < options_.trusted_score &&
            agreement_at(points, pyramid, result.match.target_T_source) < kSearchMinScore);
  };
  if (!is_lost()) return result;
  // It contradicts what was seen before: scans are missing, or the robot was carried. It may face
  // anywhere; among so many poses only one that explains what scans usually explain is no chance.
  const SearchWindow anywhere{likeliest.target_T_source, std::max(kLostM, window.half_xy_m), kPi};
  result.match = best_of(result.match, frozen.search_pyramid(submap_options_, anywhere.half_xy_m),
                         anywhere, least_score());
  result.lost = is_lost();
  return result;
}

double FrontEnd::least_score() const {
  return std::max(options_.trusted_score, usual_score_ - kScoreDrop);
}

bool FrontEnd::moved_enough(const Pose2& local_T_robot) const {
  return std::hypot(local_T_robot.x - last_key_.x, local_T_robot.y - last_key_.y) >=
             options_.key_distance_m ||
         std::abs(wrap_angle(local_T_robot.yaw - last_key_.yaw)) >= options_.key_angle_rad;
}

void FrontEnd::insert(std::span<const SurfacePoint> surfaces, const LaserScan& scan,
                      const Pose2& robot_T_lidar, TrackedScan& tracked) {
  const double step =
      std::hypot(tracked.local_T_robot.x - last_key_.x, tracked.local_T_robot.y - last_key_.y);
  for (auto& active : active_) active.travelled_m += step;
  const bool start_next =
      active_.empty() || active_.back().travelled_m >= 0.5 * options_.submap_length_m;
  if (start_next) {
    if (active_.size() == 2) {
      tracked.finished.push_back(
          {active_.front().submap.freeze(), active_.front().first_key, key_count_ - 1, piece_});
      active_.erase(active_.begin());
    }
    active_.push_back({Submap(submap_options_), tracked.local_T_robot, key_count_, 0.0});
  }
  for (auto& active : active_) {
    active.submap.insert(surfaces, scan, robot_T_lidar,
                         active.local_T_submap.inverse() * tracked.local_T_robot, beams_);
  }
  last_key_ = tracked.local_T_robot;
  ++key_count_;
  tracked.key = true;
  tracked.starts_submap = start_next;
}

std::vector<FinishedSubmap> FrontEnd::end_piece() {
  std::vector<FinishedSubmap> finished;
  for (const auto& active : active_)
    finished.push_back({active.submap.freeze(), active.first_key, key_count_ - 1, piece_});
  active_.clear();
  return finished;
}

std::vector<FinishedSubmap> FrontEnd::finish() { return end_piece(); }

}  // namespace loopstone
