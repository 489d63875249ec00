#include "loopstone/slam/motion_predictor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/base/sound_state.hpp"

namespace loopstone {

namespace {

constexpr auto kMostSteps = static_cast<std::size_t>(kMotionPredictor.steps);

Eigen::Matrix3d information_of(double sigma, double sigma_yaw) {
  return Eigen::Vector3d(1.0 / (sigma * sigma), 1.0 / (sigma * sigma),
                         1.0 / (sigma_yaw * sigma_yaw))
      .asDiagonal();
}

/// Whether two readings count from the same start.
bool comparable(const std::optional<OdometryReading>& a, const std::optional<OdometryReading>& b) {
  return a && b && a->has_translation == b->has_translation;
}

/// How wrong a motion may be that odometry tells.
ToldMotion reach_of(const Pose2& said, const OdometryReading& from, const OdometryReading& to) {
  const double travelled = std::max(hypotenuse(said.x, said.y), to.path_m - from.path_m);
  const double turned = std::max(std::abs(said.yaw), to.turned_rad - from.turned_rad);
  return {said, kMotionPredictor.wheel_rest_m + kMotionPredictor.wheel_share * travelled,
          kMotionPredictor.wheel_rest_rad + kMotionPredictor.wheel_share * turned +
              kMotionPredictor.wheel_rad_per_m * travelled};
}

double distance(const Pose2& a, const Pose2& b) { return hypotenuse(a.x - b.x, a.y - b.y); }
double turn(const Pose2& a, const Pose2& b) { return std::abs(wrap_angle(a.yaw - b.yaw)); }

/// What is left of a motion that a part of odometry tells which is not trusted: of one that stands
/// while the robot moves, or moves while it stands, nothing.
double share_of(const MotionAgreement& agreement) {
  if (agreement.trusted()) return 1.0;
  switch (agreement.fault()) {
    case OdometryFault::kStuck:
    case OdometryFault::kSpinning:
      return 0.0;
    case OdometryFault::kScaled:
    case OdometryFault::kMirrored:
      return agreement.ratio() != 0.0 ? 1.0 / agreement.ratio() : 0.0;
    case OdometryFault::kLagging:
    case OdometryFault::kWrong:
      return 1.0;
  }
  return 1.0;
}

/// Odometry that is not trusted is hearsay. But while the laser sees nothing there is nothing else,
/// and no motion goes on for ever.
Pose2 hearsay(const Pose2& said, const OdometryCheck& check) {
  const double way = share_of(check.translation());
  return {way * said.x, way * said.y, share_of(check.rotation()) * said.yaw};
}

}  // namespace

double MotionPredictor::coast_sigma_m() const { return std::sqrt(own_.coast_variance_m2); }
double MotionPredictor::coast_sigma_rad() const { return std::sqrt(own_.coast_variance_rad2); }

std::vector<Pose2> MotionPredictor::coasts(Stamp stamp) const {
  if (own_.steps.empty() || !own_.last_stamp) return {Pose2{}};
  const Tangent2& last = own_.steps.back().motion;
  std::vector<Pose2> motions{exp(last)};
  double seconds = 0.0;
  Tangent2 sum = Tangent2::Zero();
  for (const Step& step : own_.steps) {
    seconds += step.seconds;
    sum += step.motion;
  }
  const double ahead =
      std::clamp((stamp - *own_.last_stamp).seconds(), 0.0, kMotionPredictor.longest_coast_s);
  if (seconds <= 0.0) return motions;
  const Pose2 as_fast = exp(Tangent2(sum * (ahead / seconds)));
  if (distance(as_fast, motions[0]) > kMotionPredictor.same_m ||
      turn(as_fast, motions[0]) > kMotionPredictor.same_rad)
    motions.push_back(as_fast);
  return motions;
}

bool MotionPredictor::coast_is_over(Stamp stamp) const {
  if (!own_.last_stamp || own_.steps.empty()) return false;
  double usual_s = 0.0;
  for (const Step& step : own_.steps) usual_s = std::max(usual_s, step.seconds);
  const double seconds = (stamp - *own_.last_stamp).seconds();
  return seconds > kMotionPredictor.longest_coast_s &&
         seconds > kMotionPredictor.longest_coast_steps * usual_s;
}

std::vector<MotionGuess> MotionPredictor::coast_guesses(Stamp stamp) const {
  if (coast_is_over(stamp)) return {};
  const Eigen::Matrix3d loose = information_of(coast_sigma_m(), coast_sigma_rad());
  std::vector<MotionGuess> guesses;
  for (const Pose2& motion : coasts(stamp))
    guesses.push_back({own_.last_pose * motion, loose, false});
  return guesses;
}

std::vector<MotionGuess> MotionPredictor::guesses(
    Stamp stamp, const std::optional<OdometryReading>& odometry) const {
  if (!own_.last_stamp)
    return {{Pose2{}, information_of(kMotionPredictor.first_m, kMotionPredictor.first_rad), false}};
  const double blind_s = (stamp - *own_.last_stamp).seconds();
  const bool over = coast_is_over(stamp);
  if (!comparable(odometry, own_.last_odometry) || was_silent(*odometry)) {
    if (!over) return coast_guesses(stamp);
    return {{own_.last_pose * (odometry ? gone_on(blind_s) : Pose2{}),
             information_of(fastest_m_s() * blind_s, fastest_rad_s() * blind_s), false}};
  }
  std::vector<Pose2> going_on = over ? std::vector<Pose2>{Pose2{}} : coasts(stamp);
  std::vector<MotionGuess> guesses;
  const Pose2 said = corrected_motion(*own_.last_odometry, *odometry);
  // Wheels say nothing of where hands carry the robot, a gyro how they turn it.
  const bool is_lifted = is_in_hands(*odometry);
  const bool translates =
      odometry->has_translation && !is_lifted && (!checks_ || check_.trusts_translation());
  const bool turns =
      (!is_lifted || feels_hands(*odometry)) && (!checks_ || check_.trusts_rotation());
  const ToldMotion reach = step_reach(said, *odometry);
  const double coast_m = over ? fastest_m_s() * blind_s : coast_sigma_m();
  const double coast_rad = over ? fastest_rad_s() * blind_s : coast_sigma_rad();
  const Eigen::Matrix3d information =
      information_of(translates ? reach.sigma_m : coast_m, turns ? reach.sigma_rad : coast_rad);
  if (translates && turns) {
    guesses.push_back({own_.last_pose * said, information, true});
    if (!checks_) return guesses;
    const bool unlikely = std::all_of(going_on.begin(), going_on.end(), [&](const Pose2& motion) {
      return distance(said, motion) > kMotionPredictor.unlikely * coast_sigma_m() ||
             turn(said, motion) > kMotionPredictor.unlikely * coast_sigma_rad();
    });
    if (unlikely) {
      for (const MotionGuess& guess : coast_guesses(stamp)) guesses.push_back(guess);
    }
    return guesses;
  }
  const bool is_blind = (stamp - own_.placed).seconds() > kMotionPredictor.longest_gone_on_s;
  if (is_blind && odometry->has_translation) going_on = {hearsay(said, check_)};
  for (const Pose2& motion : going_on) {
    const Pose2& translation = translates ? said : motion;
    const Pose2& rotation = turns ? said : motion;
    guesses.push_back({own_.last_pose * Pose2{translation.x, translation.y, rotation.yaw},
                       information, translates});
  }
  return guesses;
}

bool MotionPredictor::heading_is_steady() const {
  if (!checks_) return false;
  const auto usual_rad = accuracy_.usual_rad(correction());
  return usual_rad && *usual_rad < kMotionPredictor.steady_rad;
}

ToldMotion MotionPredictor::step_reach(const Pose2& said, const OdometryReading& to) const {
  ToldMotion reach = reach_of(said, *own_.last_odometry, to);
  if (heading_is_steady())
    reach.sigma_rad -= kMotionPredictor.wheel_rest_rad - kMotionPredictor.steady_rest_rad;
  return reach;
}

/// Across a gap a robot more likely went on than stopped; a turn is soon over.
Pose2 MotionPredictor::gone_on(double seconds) const {
  double step_s = 0.0;
  Tangent2 sum = Tangent2::Zero();
  for (const Step& step : own_.steps) {
    step_s += step.seconds;
    sum += step.motion;
  }
  if (step_s <= 0.0) return {};
  Tangent2 velocity = sum / step_s;
  const double turning_s = std::min(seconds, kMotionPredictor.longest_coast_s);
  const double straight_s = std::min(seconds, kMotionPredictor.longest_gone_on_s) - turning_s;
  const Pose2 turned = exp(Tangent2(velocity * turning_s));
  velocity.z() = 0.0;
  return turned * exp(Tangent2(velocity * straight_s));
}

bool MotionPredictor::feels_hands(const OdometryReading& odometry) const {
  return lift_.felt_rad(odometry) > kMotionPredictor.by_hand_rad;
}

bool MotionPredictor::is_in_hands(const OdometryReading& odometry) const {
  const bool was_lifted = lift_.is_lifted() && !lift_.ended_by(odometry);
  return was_lifted || feels_hands(odometry);
}

/// Since the last scan: what it says of the motion from there is hearsay.
bool MotionPredictor::was_silent(const OdometryReading& odometry) const {
  return own_.last_stamp && odometry.silent_until && *odometry.silent_until > *own_.last_stamp;
}

OdometryCorrection MotionPredictor::correction() const {
  if (!checks_) return {};
  // What was wrong wherever the laser could see it is so where it can't, too.
  const Eigen::Vector2d missed = turns_.missed();
  return {check_.translation().scale().value_or(1.0), missed.x(), missed.y()};
}

Pose2 MotionPredictor::corrected_motion(const OdometryReading& from,
                                        const OdometryReading& to) const {
  return correction().corrected(from.odom_T_robot.inverse() * to.odom_T_robot,
                                to.path_m - from.path_m);
}

/// Both readings have a translation, and odometry is trusted with all of a motion.
bool MotionPredictor::may_tell(const OdometryReading& from, const OdometryReading& to) const {
  return from.has_translation && to.has_translation &&
         (!checks_ || (check_.trusts_translation() && check_.trusts_rotation()));
}

std::optional<ToldMotion> MotionPredictor::told(const OdometryReading& from, Stamp from_stamp,
                                                const OdometryReading& to) const {
  if (!may_tell(from, to)) return {};
  if (to.silent_until && *to.silent_until > from_stamp) return {};
  // From scan to scan, if there were any, for then it is known where it turned.
  const bool was_followed = own_.unseen && own_.unseen->from == from_stamp;
  const Pose2 motion = was_followed
                           ? own_.unseen->motion * corrected_motion(*own_.last_odometry, to)
                           : corrected_motion(from, to);
  return left_over(motion, from, to);
}

std::optional<PartlyToldMotion> MotionPredictor::partly_told(const OdometryReading& from,
                                                             Stamp from_stamp,
                                                             const OdometryReading& to,
                                                             Stamp to_stamp) const {
  if (!may_tell(from, to) || !own_.last_odometry || !own_.last_stamp) return {};
  UnseenMotion way = own_.unseen.value_or(UnseenMotion{*own_.last_stamp});
  if (way.from != from_stamp) return {};
  go_on_unseen(to_stamp, to, way);
  const ToldMotion told = left_over(way.motion * way.after, from, to);
  return PartlyToldMotion{way.motion, way.untold_s, way.after,
                          way.told_m, told.sigma_m, told.sigma_rad};
}

/// How wrong a motion may be without the errors that are known.
ToldMotion MotionPredictor::left_over(const Pose2& motion, const OdometryReading& from,
                                      const OdometryReading& to) const {
  const double reach_m = motion.translation().norm();
  const double path_m = std::max(reach_m, to.path_m - from.path_m);
  const double turned = std::max(std::abs(motion.yaw), to.turned_rad - from.turned_rad);
  const auto left = accuracy_.sigma(path_m, reach_m, correction());
  const double always_rad =
      turns_.sigma_rad(way_and_turn(from.odom_T_robot.inverse() * to.odom_T_robot, path_m));
  return {motion, kMotionPredictor.wheel_rest_m + hypotenuse(left.m, 0.5 * always_rad * reach_m),
          kMotionPredictor.wheel_rest_rad + kMotionPredictor.turn_share * turned +
              hypotenuse(left.rad, always_rad)};
}

void MotionPredictor::settle(Stamp stamp, const Pose2& local_T_robot,
                             const std::optional<OdometryReading>& odometry, Seen seen) {
  if (own_.last_stamp) {
    const Pose2 motion = own_.last_pose.inverse() * local_T_robot;
    const bool goes_on = odometry && !was_silent(*odometry) && !lift_.is_lifted();
    follow_unseen(stamp, local_T_robot, odometry, seen);
    // Where a gap ended the laser found by what it looks like, and may be wrong.
    const bool was_followed = !coast_is_over(stamp);
    if (goes_on && was_followed && comparable(odometry, own_.last_odometry) && checks_) {
      check_odometry(stamp, motion, *odometry, seen);
      learn_turns(motion, *odometry, seen);
    } else {
      turns_.interrupt();
    }
    if (odometry && !goes_on) accuracy_.interrupt();
    if (odometry && odometry->has_translation && seen.translation) {
      accuracy_.add(odometry->odom_T_robot, local_T_robot, odometry->path_m);
    } else if (!seen.rotation) {
      accuracy_.interrupt();
    }
    if (seen.rotation && !own_.steps.empty()) learn_coast(stamp, motion, seen);
    measure_speed((stamp - *own_.last_stamp).seconds(), motion, seen);
    remember_step(stamp, motion);
  }
  watch_lift(stamp, local_T_robot, odometry, seen);
  if (!own_.last_stamp || seen.translation || seen.rotation) own_.placed = stamp;
  own_.last_stamp = stamp;
  own_.last_pose = local_T_robot;
  own_.last_odometry = odometry;
  own_.last_seen = seen;
}

/// Odometry that is not trusted says nothing of hands.
void MotionPredictor::watch_lift(Stamp stamp, const Pose2& local_T_robot,
                                 const std::optional<OdometryReading>& odometry, Seen seen) {
  const bool may_tell = checks_ && odometry && !was_silent(*odometry) &&
                        check_.trusts_translation() && check_.trusts_rotation();
  if (may_tell) {
    lift_.add(stamp, *odometry, local_T_robot, seen.translation, seen.rotation);
  } else {
    lift_.forget();
  }
}

/// \param motion  from the last scan, as it was settled
void MotionPredictor::check_odometry(Stamp stamp, const Pose2& motion,
                                     const OdometryReading& odometry, Seen seen) {
  check_.add({.from = *own_.last_stamp,
              .to = stamp,
              .odometry = own_.last_odometry->odom_T_robot.inverse() * odometry.odom_T_robot,
              .laser = motion,
              .sees_translation = seen.translation && own_.last_seen.translation,
              .sees_rotation = seen.rotation && own_.last_seen.rotation,
              .odometry_has_translation = odometry.has_translation});
}

void MotionPredictor::learn_turns(const Pose2& motion, const OdometryReading& odometry, Seen seen) {
  if (!seen.rotation || !own_.last_seen.rotation || !check_.trusts_rotation()) {
    turns_.interrupt();
    return;
  }
  const Pose2 said = own_.last_odometry->odom_T_robot.inverse() * odometry.odom_T_robot;
  turns_.add(way_and_turn(said, odometry.path_m - own_.last_odometry->path_m), motion.yaw);
}

/// As long as scans stand where odometry alone would have them, or nothing tells where they do.
void MotionPredictor::follow_unseen(Stamp stamp, const Pose2& local_T_robot,
                                    const std::optional<OdometryReading>& odometry, Seen seen) {
  const auto is_unseen = [&] {
    if (!comparable(odometry, own_.last_odometry)) return false;
    if (was_silent(*odometry)) return !seen.translation && !seen.rotation;
    return local_T_robot == own_.last_pose * corrected_motion(*own_.last_odometry, *odometry);
  };
  if (!is_unseen()) {
    own_.unseen.reset();
    return;
  }
  if (!own_.unseen) own_.unseen = UnseenMotion{*own_.last_stamp};
  go_on_unseen(stamp, *odometry, *own_.unseen);
}

/// From the last scan to the next one.
void MotionPredictor::go_on_unseen(Stamp stamp, const OdometryReading& odometry,
                                   UnseenMotion& unseen) const {
  if (was_silent(odometry)) {
    unseen.untold_s += (stamp - *own_.last_stamp).seconds();
    return;
  }
  Pose2& told = unseen.untold_s > 0.0 ? unseen.after : unseen.motion;
  told = told * corrected_motion(*own_.last_odometry, odometry);
  unseen.told_m += odometry.path_m - own_.last_odometry->path_m;
}

/// How wrong a motion that goes on is, from how wrong it was.
void MotionPredictor::learn_coast(Stamp stamp, const Pose2& motion, Seen seen) {
  // The nearer of the guesses counts: the other one was for irregular stamps.
  double off = kMotionPredictor.coast_most_m;
  double off_yaw = kMotionPredictor.coast_most_rad;
  for (const Pose2& guess : coasts(stamp)) {
    if (seen.translation) off = std::min(off, distance(guess, motion));
    off_yaw = std::min(off_yaw, turn(guess, motion));
  }
  const auto learn = [](double& variance, double error, double least, double most) {
    variance += (error * error - variance) / kMotionPredictor.coast_memory;
    variance = std::clamp(variance, least * least, most * most);
  };
  if (seen.translation) {
    learn(own_.coast_variance_m2, off, kMotionPredictor.coast_least_m,
          kMotionPredictor.coast_most_m);
  }
  learn(own_.coast_variance_rad2, off_yaw, kMotionPredictor.coast_least_rad,
        kMotionPredictor.coast_most_rad);
}

/// A speed that was seen once may be a mistake of the laser, and counts half.
void MotionPredictor::measure_speed(double seconds, const Pose2& motion, Seen seen) {
  Speeds& speeds = own_.speeds;
  if (!seen.translation || !seen.rotation || seconds > kMotionPredictor.longest_coast_s) {
    speeds.window_s = speeds.window_m = speeds.window_back_m = speeds.window_rad = 0.0;
    return;
  }
  speeds.window_s += std::max(0.0, seconds);
  speeds.window_m += hypotenuse(motion.x, motion.y);
  speeds.window_back_m += std::max(0.0, -motion.x);
  speeds.window_rad += std::abs(motion.yaw);
  if (speeds.window_s < kMotionPredictor.speed_window_s) return;
  const auto raise = [&](double& top, double way) {
    top = std::max(top, 0.5 * (top + way / speeds.window_s));
  };
  raise(speeds.top_m_s, speeds.window_m);
  raise(speeds.top_back_m_s, speeds.window_back_m);
  raise(speeds.top_rad_s, speeds.window_rad);
  if (speeds.window_m > kMotionPredictor.moves_m || speeds.window_rad > kMotionPredictor.moves_rad)
    ++speeds.windows;
  speeds.window_s = speeds.window_m = speeds.window_back_m = speeds.window_rad = 0.0;
}

bool MotionPredictor::knows_speeds() const {
  return own_.speeds.windows >= kMotionPredictor.speed_windows;
}

double MotionPredictor::fastest_m_s() const {
  return std::max(kMotionPredictor.speed_margin * own_.speeds.top_m_s,
                  knows_speeds() ? kMotionPredictor.slowest_m_s : kMotionPredictor.walking_m_s);
}

double MotionPredictor::fastest_back_m_s() const {
  return knows_speeds() ? kMotionPredictor.speed_margin * own_.speeds.top_back_m_s
                        : kMotionPredictor.walking_m_s;
}

double MotionPredictor::fastest_rad_s() const {
  return std::max(kMotionPredictor.speed_margin * own_.speeds.top_rad_s,
                  knows_speeds() ? kMotionPredictor.slowest_rad_s : kMotionPredictor.walking_rad_s);
}

/// A motion across a gap does not go on.
void MotionPredictor::remember_step(Stamp stamp, const Pose2& motion) {
  if (coast_is_over(stamp)) {
    own_.steps.clear();
    return;
  }
  own_.steps.push_back({std::max(0.0, (stamp - *own_.last_stamp).seconds()), log(motion)});
  if (own_.steps.size() > kMostSteps) own_.steps.pop_front();
}

MotionPredictor::State MotionPredictor::state() const {
  return {check_.state(), accuracy_.state(), turns_.state(), lift_.state(), own_};
}

void MotionPredictor::restore(State state) {
  const State::Own& own = state.own;
  require_sound(own.steps.size() <= kMostSteps, "more motions than are remembered");
  require_sound(own.steps.empty() || own.last_stamp, "motions before the first scan");
  require_sound(!own.unseen || own.last_odometry, "motion that nothing told");
  require_sound(!own.unseen || (is_amount(own.unseen->untold_s) && is_amount(own.unseen->told_m) &&
                                own.unseen->motion.vector().allFinite() &&
                                own.unseen->after.vector().allFinite()),
                "motion that is no number");
  require_sound(is_amount(own.coast_variance_m2) && own.coast_variance_m2 > 0.0 &&
                    is_amount(own.coast_variance_rad2) && own.coast_variance_rad2 > 0.0,
                "a variance that can't be");
  check_.restore(std::move(state.check));
  accuracy_.restore(std::move(state.accuracy));
  turns_.restore(std::move(state.turns));
  lift_.restore(state.lift);
  own_ = std::move(state.own);
}

}  // namespace loopstone
