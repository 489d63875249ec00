#include "loopstone/slam/lift_watch.hpp"

#include <cmath>

#include "loopstone/base/sound_state.hpp"
#include "loopstone/geometry/pose_distance.hpp"

namespace loopstone {

bool LiftWatch::still_stands(const OdometryReading& reading) const {
  if (!state_.stands || !reading.has_translation) return false;
  const OdometryReading& since = *state_.stands;
  return reading.path_m - since.path_m < kLiftWatch.stands_m &&
         is_within(reading.odom_T_robot, since.odom_T_robot, kLiftWatch.stands_m,
                   kLiftWatch.stands_rad + felt_rad(reading));
}

double LiftWatch::felt_rad(const OdometryReading& reading) const {
  return state_.stands ? reading.turned_by_hand_rad - state_.stands->turned_by_hand_rad : 0.0;
}

std::optional<Lift> LiftWatch::ended_by(const OdometryReading& reading) const {
  if (!state_.is_lifted || (still_stands(reading) && !state_.is_stuck)) return {};
  return state_.lift;
}

void LiftWatch::add(Stamp stamp, const OdometryReading& reading, const Pose2& local_T_robot,
                    bool sees_translation, bool sees_rotation) {
  const double seconds = state_.stands ? (stamp - state_.last).seconds() : 0.0;
  if (!still_stands(reading)) {
    state_ = {.stands = reading, .local_T_robot = local_T_robot, .last = stamp, .lift = {stamp}};
    return;
  }
  state_.last = stamp;
  if (!sees_translation) state_.lift.unseen_s += seconds;
  if (state_.is_stuck) {
    state_.is_lifted = false;
    return;
  }
  state_.is_stuck = state_.is_lifted && (stamp - state_.lift.from).seconds() > kLiftWatch.longest_s;
  if (state_.is_lifted || !sees_rotation) return;
  // Along what it leaves open the laser repeats what the wheels say.
  if (is_within(local_T_robot, state_.local_T_robot, kLiftWatch.rests_m, kLiftWatch.stands_rad)) {
    state_.lift = {stamp};
    return;
  }
  state_.is_lifted =
      !is_within(local_T_robot, state_.local_T_robot, kLiftWatch.moves_m, kLiftWatch.turns_rad) &&
      (stamp - state_.lift.from).seconds() > kLiftWatch.at_least_s;
}

void LiftWatch::restore(const State& state) {
  require_sound(is_amount(state.lift.unseen_s) && state.local_T_robot.vector().allFinite(),
                "a lift that is no number");
  require_sound(state.stands || !state.is_lifted, "a robot that was lifted and never stood");
  state_ = state;
}

}  // namespace loopstone
