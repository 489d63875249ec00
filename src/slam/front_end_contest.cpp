// Who is at fault where laser and odometry disagree: the map is the third witness.

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "loopstone/slam/front_end.hpp"
#include "slam/front_end_numbers.hpp"
#include "slam/pose_search.hpp"

namespace loopstone {

/// Odometry has proved itself, and says that the robot drives or turns: nobody carries it.
bool FrontEnd::is_driven(const Sighting& sighting) const {
  if (!sighting.odometry || sighting.guesses.size() > 1) return false;
  const OdometryCheck& check = predictor_.check();
  if (!sighting.likeliest().measured || !check.trusts_rotation() || !check.translation().scale())
    return false;
  return is_said_to_drive(sighting);
}

/// Drives or turns, as the likeliest guess has it.
bool FrontEnd::is_said_to_drive(const Sighting& sighting) const {
  const Pose2 motion = predictor_.last_pose().inverse() * sighting.likeliest().local_T_robot;
  // Of scans whose stamps jitter, or of several lasers, one may come right after another.
  const double seconds = (sighting.scan->stamp - *predictor_.last_stamp()).seconds();
  const double share = own_.held && seconds < own_.held->usual_seconds
                           ? std::max(0.0, seconds) / own_.held->usual_seconds
                           : 1.0;
  const double by_hand_rad = predictor_.lift().felt_rad(*sighting.odometry);
  return share > 0.0 && (motion.translation().norm() >= share * kFrontEnd.drives_m ||
                         std::abs(motion.yaw) - by_hand_rad >= share * kFrontEnd.turns_rad);
}

/// The map explains much less of the scan than usual.
bool FrontEnd::explains_less(const Alignment& alignment) const {
  return alignment.lost || alignment.match.status == MatchStatus::kTooFewPairs ||
         alignment.match.score < own_.usual_score - kFrontEnd.score_drop;
}

/// The laser finds the robot where odometry says, as far as chance allows.
bool FrontEnd::agrees(const Alignment& alignment, const Sighting& sighting) {
  if (alignment.searched || !has_supported_pose(alignment.match.status)) return false;
  const MotionGuess& guess = sighting.likeliest();
  return chi2_from({guess.local_T_robot, guess.information, guess.measured}, alignment.match) <=
         kFrontEnd.most_guess_chi2;
}

/// The laser says that the robot went elsewhere, faster than it has ever been seen to go.
bool FrontEnd::leaps(const Alignment& alignment, const Sighting& sighting) const {
  const Pose2& pose = alignment.match.target_T_source;
  const auto far_from = [&](const Pose2& other) {
    return (pose.translation() - other.translation()).norm();
  };
  const double seconds = (sighting.scan->stamp - *predictor_.last_stamp()).seconds();
  return far_from(sighting.likeliest().local_T_robot) > kFrontEnd.leap_m &&
         far_from(predictor_.last_pose()) >
             kFrontEnd.leap_m + predictor_.fastest_m_s() * std::max(0.0, seconds);
}

/// Where the map explains less than usual, only what odometry says as well; after scans that
/// contradicted the map, only where odometry can have led meanwhile.
bool FrontEnd::is_believed(const Alignment& alignment, const Sighting& sighting) const {
  if (explains_less(alignment)) return agrees(alignment, sighting);
  if (own_.lost_in_a_row == 0) return !leaps(alignment, sighting);
  const BlindMotion led =
      blind_motion(sighting.scan->stamp, sighting.likeliest(), sighting.odometry);
  return !led.prior.holds_unobserved ||
         chi2_from(led.prior, alignment.match) <= kFrontEndRejoin.fits_chi2;
}

/// What a scan shows for the first time, as far as the scans before can tell.
void FrontEnd::take_out_new(Sighting& sighting) {
  Pose2 ground_T_robot = sighting.likeliest().local_T_robot;
  ground_T_robot.x += own_.local_to_ground_m.x();
  ground_T_robot.y += own_.local_to_ground_m.y();
  const std::vector<bool> found =
      travelling_.find_new(*sighting.whole, ground_T_robot * sighting.robot_T_lidar,
                           sighting.odometry->path_m, sighting.cover.beams, beams_);
  if (!found.empty()) sighting.cover.beams.resize(found.size(), false);
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i]) sighting.cover.beams[i] = true;
  }
  uncovered_ = *sighting.whole;
  if (!sighting.cover.beams.empty()) take_out(sighting.cover.beams, uncovered_);
  sighting.scan = &uncovered_;
  straighten(sighting, velocity_to(sighting.likeliest().local_T_robot, *sighting.whole));
}

/// The laser contradicts odometry, which was right so far, and the map explains the scan badly:
/// what it shows for the first time is left out. If the map explains the rest as usual, wherever
/// that is, the laser is right: wheels slip. Else odometry leads.
FrontEnd::Alignment FrontEnd::contest(Sighting& sighting) {
  take_out_new(sighting);
  Alignment led = lead(sighting);
  if (!explains_less(led)) return led;
  Alignment freed = align(sighting.matched(), std::span(sighting.guesses).first(1), {}, true);
  if (!freed.searched && !explains_less(freed) && is_believed(freed, sighting)) return freed;
  sighting.is_led = true;
  return led;
}

/// Odometry's pose, made better by what of the scan fits there.
FrontEnd::Alignment FrontEnd::lead(const Sighting& sighting) const {
  const MotionGuess& guess = sighting.likeliest();
  const PosePrior2 prior = in_submap({guess.local_T_robot, guess.information, guess.measured});
  const ActiveSubmap& target = active_.front();
  Alignment result;
  MatchResult match = match_to_grid(sighting.matched(), target.submap.surfaces(),
                                    prior.target_T_source, prior, match_options_, 1);
  if (!has_supported_pose(match.status) || match.score < options_.trusted_score ||
      chi2_from(prior, match) > kFrontEnd.most_guess_chi2) {
    match.target_T_source = prior.target_T_source;
    match.covariance = prior.information.inverse();
    match.status = MatchStatus::kTooFewPairs;
    const auto points = search_points(sighting.matched());
    result.lost =
        !is_unfamiliar(points, target.submap.freeze().search_pyramid(submap_options_, 0.0), prior);
    if (result.lost) match.status = MatchStatus::kNotConverged;
  }
  result.match = in_local(match);
  return result;
}

}  // namespace loopstone
