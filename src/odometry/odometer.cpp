#include "loopstone/odometry/odometer.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "loopstone/base/sound_state.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {

namespace {

constexpr Duration kMemory = Duration::from_milliseconds(kOdometer.memory_ms);
constexpr Duration kGyroWait = Duration::from_milliseconds(kOdometer.gyro_wait_ms);
constexpr Duration kGyroSilence = Duration::from_milliseconds(kOdometer.gyro_silence_ms);
constexpr Duration kLargestGyroGap = Duration::from_milliseconds(kOdometer.largest_gyro_gap_ms);
constexpr Duration kGyroHold = Duration::from_milliseconds(kOdometer.gyro_hold_ms);
constexpr Duration kStandstill = Duration::from_milliseconds(kOdometer.standstill_ms);
constexpr Duration kHands = Duration::from_milliseconds(kOdometer.hands_ms);
constexpr Duration kVelocitySpan = Duration::from_milliseconds(kOdometer.velocity_span_ms);

/// Whether these come one after the other.
template <typename Stamped>
bool stamps_increase(const std::deque<Stamped>& values) {
  return std::ranges::adjacent_find(values, [](const Stamped& a, const Stamped& b) {
           return !(a.stamp < b.stamp);
         }) == values.end();
}

double seconds_between(Stamp from, Stamp to) { return (to - from).seconds(); }

bool finite(const Pose2& pose) {
  return std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.yaw);
}

}  // namespace

Odometer::Odometer(const WheelModel& wheels, const OdometryOptions& options)
    : wheels_(wheels), options_(options) {}

void Odometer::add(const WheelTicks& ticks) {
  if (own_.source == Source::kPoses) return;
  if (own_.last_ticks && ticks.stamp <= own_.last_ticks->stamp) return;
  own_.source = Source::kWheels;
  if (!own_.started) own_.started = ticks.stamp;
  own_.seen_until = std::max(own_.seen_until, ticks.stamp);
  if (!own_.last_ticks) {
    // What the first reading counted happened before we know when: only its stamp is of use.
    if (own_.nodes.empty()) {
      append(ticks.stamp, Pose2{}, Eigen::Matrix3d::Zero());
    } else if (own_.nodes.back().stamp < ticks.stamp) {  // restarted before the first reading
      append(ticks.stamp, own_.nodes.back().odom_T_robot.pose, Eigen::Matrix3d::Zero());
    }
    own_.last_ticks = ticks;
    return;
  }
  const auto counts = counts_between(*own_.last_ticks, ticks, wheels_);
  Interval interval{own_.last_ticks->stamp, ticks.stamp, motion_of(counts, wheels_)};
  const bool was_reset =
      wheels_.counts_are_cumulative &&
      std::abs(interval.motion.distance_m) >
          kOdometer.fastest_wheel_m_s *
              std::max(kOdometer.shortest_reset_s, seconds_between(interval.from, interval.to));
  if (was_reset) interval.motion = ArcMotion{};
  interval.still =
      !was_reset && std::all_of(counts.begin(), counts.end(), [](auto c) { return c == 0; });
  own_.last_ticks = ticks;
  own_.waiting.push_back(interval);
  integrate_waiting(false);
}

void Odometer::add(const ImuSample& sample) {
  const double rate = sample.angular_velocity_rad_s.z();
  if (!std::isfinite(rate)) return;
  if (!own_.rates.empty() && sample.stamp <= own_.rates.back().stamp) return;
  if (options_.yaw == YawSource::kWheels) return;
  if (own_.source == Source::kPoses) {  // which turn the robot; it is their witness
    own_.rates.push_back({sample.stamp, rate});
    forget_rates_before(sample.stamp - kLargestGyroGap);
    return;
  }
  if (!own_.started) own_.started = sample.stamp;
  own_.seen_until = std::max(own_.seen_until, sample.stamp);
  own_.rates.push_back({sample.stamp, rate});
  integrate_waiting(false);
  if (own_.waiting.empty()) forget_rates_before(sample.stamp - kLargestGyroGap);
}

void Odometer::add(const OdometryPose& pose) {
  if (own_.source == Source::kWheels || !finite(pose.odom_T_robot)) return;
  if (own_.last_pose && pose.stamp <= own_.last_pose->stamp) return;
  own_.source = Source::kPoses;
  const bool restarted_before_first = !own_.last_pose && !own_.nodes.empty();
  if (restarted_before_first) {
    own_.odom_T_log_odom = own_.nodes.back().odom_T_robot.pose * pose.odom_T_robot.inverse();
  }
  if (own_.last_pose) compare_with_gyro(*own_.last_pose, pose);
  own_.last_pose = pose;
  if (own_.counted_from && pose.stamp <= *own_.counted_from) return;
  const Pose2 odom_T_robot = own_.odom_T_log_odom * pose.odom_T_robot;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  if (!own_.nodes.empty()) {
    const Pose2 motion = own_.nodes.back().odom_T_robot.pose.inverse() * odom_T_robot;
    covariance = motion_covariance(motion.translation().norm(), motion.yaw, false, options_);
  }
  append(pose.stamp, odom_T_robot, covariance);
}

void Odometer::finish() { integrate_waiting(true); }

void Odometer::integrate_waiting(bool all) {
  while (!own_.waiting.empty() && (all || !gyro_may_still_come(own_.waiting.front().to))) {
    const Interval interval = own_.waiting.front();
    own_.waiting.pop_front();
    integrate(interval);
  }
}

bool Odometer::gyro_may_still_come(Stamp stamp) const {
  if (options_.yaw == YawSource::kWheels) return false;
  if (!own_.rates.empty() && own_.rates.back().stamp >= stamp) return false;
  if (own_.seen_until - stamp > kGyroWait) return false;
  const Stamp last_sign = own_.rates.empty() ? *own_.started : own_.rates.back().stamp;
  return own_.seen_until - last_sign < kGyroSilence;
}

void Odometer::integrate(Interval interval) {
  if (!interval.still) own_.still_since.reset();
  if (interval.still && !own_.still_since) own_.still_since = interval.from;

  if (own_.counted_from && interval.from < *own_.counted_from) {
    if (interval.to <= *own_.counted_from) return;
    // Only the part after the restart moves the robot, at the interval's constant speed.
    const double share = seconds_between(*own_.counted_from, interval.to) /
                         seconds_between(interval.from, interval.to);
    interval = {*own_.counted_from,
                interval.to,
                {share * interval.motion.distance_m, share * interval.motion.rotation_rad},
                interval.still};
  }

  const bool standing =
      options_.use_standstill && own_.still_since && interval.to - *own_.still_since > kStandstill;
  const bool nearest = options_.alignment == StampAlignment::kNearest;
  const Rate* rate = nearest_rate(interval.to);
  const bool gyro = nearest ? rate != nullptr : gyro_covers(interval);
  if (gyro) {
    ++own_.turned_by_gyro;
  } else {
    ++own_.turned_by_wheels;
  }
  const double yaw_before = own_.nodes.back().odom_T_robot.pose.yaw;
  if (standing && (!gyro || bias_.could_be_rest(rate != nullptr ? rate->rate_rad_s : 0.0))) {
    step(interval.to, ArcMotion{}, gyro);
    learn_bias(interval);
  } else if (!gyro) {
    step(interval.to, interval.motion, false);
  } else if (nearest) {
    const double turn =
        (rate->rate_rad_s - bias_.bias_rad_s()) * seconds_between(interval.from, interval.to);
    step(interval.to, {interval.motion.distance_m, turn}, true);
  } else {
    integrate_along_gyro(interval);
    const double by_wheels = interval.motion.rotation_rad;
    const double by_gyro = wrap_angle(own_.nodes.back().odom_T_robot.pose.yaw - yaw_before);
    add_turns(by_wheels, by_gyro);
  }
  if (gyro && own_.still_since && interval.to - *own_.still_since > kHands) {
    own_.turned_by_hand_rad +=
        std::abs(wrap_angle(own_.nodes.back().odom_T_robot.pose.yaw - yaw_before));
  }
  forget_rates_before(interval.to - kLargestGyroGap);
}

void Odometer::add_turns(double by_odometry, double by_gyro) {
  own_.turns.ww += by_odometry * by_odometry;
  own_.turns.wg += by_odometry * by_gyro;
  own_.turns.gg += by_gyro * by_gyro;
}

void Odometer::compare_with_gyro(const OdometryPose& from, const OdometryPose& to) {
  if (to.stamp - from.stamp > kLargestGyroGap || !gyro_covers({from.stamp, to.stamp})) return;
  const double rate = 0.5 * (rate_at(from.stamp) + rate_at(to.stamp));
  add_turns(wrap_angle(to.odom_T_robot.yaw - from.odom_T_robot.yaw),
            rate * seconds_between(from.stamp, to.stamp));
}

std::optional<double> Odometer::wheels_with_gyro() const {
  constexpr double kEnough = kOdometer.enough_turning_rad2;
  if (own_.turns.ww < kEnough || own_.turns.gg < kEnough) return {};
  return own_.turns.wg / std::sqrt(own_.turns.ww * own_.turns.gg);
}

void Odometer::integrate_along_gyro(const Interval& interval) {
  const double speed_m_s = interval.motion.distance_m / seconds_between(interval.from, interval.to);
  Stamp begin = interval.from;
  const auto advance_to = [&](Stamp end) {
    const double seconds = seconds_between(begin, end);
    // The trapezium is exact for a rate that is linear between samples.
    const double rate = 0.5 * (rate_at(begin) + rate_at(end)) - bias_.bias_rad_s();
    step(end, {speed_m_s * seconds, rate * seconds}, true);
    begin = end;
  };
  for (const Rate& rate : own_.rates) {
    if (rate.stamp > interval.from && rate.stamp < interval.to) advance_to(rate.stamp);
  }
  advance_to(interval.to);
}

void Odometer::step(Stamp to, const ArcMotion& motion, bool yaw_from_gyro) {
  const Pose2 moved =
      options_.integration == StepShape::kEuler ? integrate_euler(motion) : integrate_arc(motion);
  append(to, own_.nodes.back().odom_T_robot.pose * moved,
         motion_covariance(motion.distance_m, motion.rotation_rad, yaw_from_gyro, options_));
}

void Odometer::append(Stamp stamp, const Pose2& odom_T_robot,
                      const Eigen::Matrix3d& step_covariance) {
  Node node{stamp, {odom_T_robot, Eigen::Matrix3d::Zero()}, step_covariance};
  if (!own_.nodes.empty()) {
    const PoseWithCovariance2& before = own_.nodes.back().odom_T_robot;
    const PoseWithCovariance2 motion{before.pose.inverse() * odom_T_robot, step_covariance};
    node.odom_T_robot.covariance = compound(before, motion).covariance;
  }
  own_.nodes.push_back(node);
  while (own_.nodes.size() > 2 && own_.nodes[1].stamp < stamp - kMemory) {
    own_.nodes.pop_front();
    own_.forgot_nodes = true;
  }
}

void Odometer::learn_bias(const Interval& interval) {
  for (const Rate& rate : own_.rates) {
    if (rate.stamp > interval.from && rate.stamp <= interval.to) {
      bias_.learn(rate.stamp, rate.rate_rad_s);
    }
  }
}

void Odometer::forget_rates_before(Stamp stamp) {
  while (own_.rates.size() > 2 && own_.rates[1].stamp < stamp) own_.rates.pop_front();
}

bool Odometer::gyro_covers(const Interval& interval) const {
  // At either end of its recording the gyro may miss a part of an interval: its nearest rate holds
  // there.
  if (own_.rates.empty() || own_.rates.front().stamp - interval.from > kGyroHold ||
      interval.to - own_.rates.back().stamp > kGyroHold) {
    return false;
  }
  for (std::size_t i = 1; i < own_.rates.size(); ++i) {
    const bool touches =
        own_.rates[i].stamp > interval.from && own_.rates[i - 1].stamp < interval.to;
    if (touches && own_.rates[i].stamp - own_.rates[i - 1].stamp > kLargestGyroGap) return false;
  }
  return true;
}

const Odometer::Rate* Odometer::nearest_rate(Stamp stamp) const {
  const Rate* best = nullptr;
  Duration distance = kGyroWait;
  for (const Rate& rate : own_.rates) {
    const Duration own = std::max(rate.stamp - stamp, stamp - rate.stamp);
    if (own < distance) {
      best = &rate;
      distance = own;
    }
  }
  return best;
}

double Odometer::rate_at(Stamp stamp) const {
  const auto after = std::lower_bound(own_.rates.begin(), own_.rates.end(), stamp,
                                      [](const Rate& rate, Stamp s) { return rate.stamp < s; });
  if (after == own_.rates.end()) return own_.rates.back().rate_rad_s;
  if (after->stamp == stamp || after == own_.rates.begin()) return after->rate_rad_s;
  const auto before = std::prev(after);
  const double ratio =
      seconds_between(before->stamp, stamp) / seconds_between(before->stamp, after->stamp);
  return before->rate_rad_s + ratio * (after->rate_rad_s - before->rate_rad_s);
}

double Odometer::untold_s(Stamp from, Stamp to) const {
  if (own_.source != Source::kWheels || wheels_.counts_are_cumulative) return 0.0;
  double sum_s = 0.0;
  for (std::size_t i = 1; i < own_.nodes.size(); ++i) {
    const Stamp begin = std::max(own_.nodes[i - 1].stamp, from);
    const Stamp end = std::min(own_.nodes[i].stamp, to);
    const Duration silent = own_.nodes[i].stamp - own_.nodes[i - 1].stamp;
    if (begin < end && silent > Duration::from_milliseconds(kOdometer.counts_gap_ms))
      sum_s += (end - begin).seconds();
  }
  return sum_s;
}

std::optional<Stamp> Odometer::newest() const {
  if (own_.nodes.empty()) return {};
  return own_.nodes.back().stamp;
}

std::optional<PoseWithCovariance2> Odometer::pose_at(Stamp stamp) const {
  if (own_.nodes.empty()) return {};
  const Duration reach = Duration::from_seconds(options_.max_extrapolation_s);
  if (stamp < own_.nodes.front().stamp) {
    if (own_.forgot_nodes || own_.nodes.front().stamp - stamp > reach) return {};
    return own_.nodes.front().odom_T_robot;
  }
  if (stamp > own_.nodes.back().stamp) {
    if (stamp - own_.nodes.back().stamp > reach) return {};
    return options_.alignment == StampAlignment::kNearest ? own_.nodes.back().odom_T_robot
                                                          : extrapolate(stamp);
  }
  const auto after = std::lower_bound(own_.nodes.begin(), own_.nodes.end(), stamp,
                                      [](const Node& node, Stamp s) { return node.stamp < s; });
  if (after->stamp == stamp) return after->odom_T_robot;
  const auto before = std::prev(after);
  if (options_.alignment == StampAlignment::kNearest) {
    const bool first_is_nearer = stamp - before->stamp <= after->stamp - stamp;
    return first_is_nearer ? before->odom_T_robot : after->odom_T_robot;
  }
  const double ratio =
      seconds_between(before->stamp, stamp) / seconds_between(before->stamp, after->stamp);
  const Pose2 whole = before->odom_T_robot.pose.inverse() * after->odom_T_robot.pose;
  const Pose2 part = interpolate(Pose2{}, whole, ratio);
  return compound(before->odom_T_robot, {part, ratio * after->step_covariance});
}

PoseWithCovariance2 Odometer::extrapolate(Stamp stamp) const {
  const Node& last = own_.nodes.back();
  // The node before may be a fraction of a millisecond away; a velocity needs a longer span.
  std::size_t i = own_.nodes.size() - 1;
  while (i > 0 && last.stamp - own_.nodes[i].stamp < kVelocitySpan) --i;
  if (i + 1 == own_.nodes.size()) return last.odom_T_robot;
  const double ratio =
      seconds_between(last.stamp, stamp) / seconds_between(own_.nodes[i].stamp, last.stamp);
  const Tangent2 twist = log(own_.nodes[i].odom_T_robot.pose.inverse() * last.odom_T_robot.pose);
  const Pose2 ahead = exp(Tangent2(ratio * twist));
  // The velocity may be all wrong by then: the motion itself is taken as the standard deviation.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  covariance(0, 0) = covariance(1, 1) = ahead.translation().squaredNorm();
  covariance(2, 2) = ahead.yaw * ahead.yaw;
  return compound(last.odom_T_robot, {ahead, covariance});
}

std::optional<PoseWithCovariance2> Odometer::motion_between(Stamp from, Stamp to) const {
  const auto odom_T_from = pose_at(from);
  const auto odom_T_to = pose_at(to);
  if (!odom_T_from || !odom_T_to || to < from) return {};
  // Steps are independent, so the motion's covariance is compounded from the steps between the two
  // stamps.
  PoseWithCovariance2 from_T_now;
  Stamp now = from;
  for (std::size_t i = 1; i < own_.nodes.size() && now < to; ++i) {
    if (own_.nodes[i].stamp <= now) continue;
    const Stamp end = std::min(own_.nodes[i].stamp, to);
    const double share = seconds_between(std::max(now, own_.nodes[i - 1].stamp), end) /
                         seconds_between(own_.nodes[i - 1].stamp, own_.nodes[i].stamp);
    const Pose2 from_T_end = odom_T_from->pose.inverse() * pose_at(end)->pose;
    from_T_now = compound(from_T_now, {from_T_now.pose.inverse() * from_T_end,
                                       share * own_.nodes[i].step_covariance});
    now = end;
  }
  if (now < to && options_.alignment != StampAlignment::kNearest && to > own_.nodes.back().stamp) {
    const Pose2 step = own_.nodes.back().odom_T_robot.pose.inverse() * odom_T_to->pose;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    covariance(0, 0) = covariance(1, 1) = step.translation().squaredNorm();
    covariance(2, 2) = step.yaw * step.yaw;
    from_T_now = compound(from_T_now, {step, covariance});
  }
  from_T_now.pose = odom_T_from->pose.inverse() * odom_T_to->pose;
  return from_T_now;
}

void Odometer::restart_at(const Pose2& odom_T_robot, Stamp stamp) {
  const auto before = pose_at(stamp);
  const std::deque<Node> old = std::exchange(own_.nodes, {});
  own_.forgot_nodes = false;
  own_.counted_from = stamp;
  append(stamp, odom_T_robot, Eigen::Matrix3d::Zero());
  if (!before) {
    if (own_.last_pose)
      own_.odom_T_log_odom = odom_T_robot * own_.last_pose->odom_T_robot.inverse();
    return;
  }
  // What is known of the motion after the stamp stays true; only where it starts has changed.
  const Pose2 new_T_old = odom_T_robot * before->pose.inverse();
  own_.odom_T_log_odom = new_T_old * own_.odom_T_log_odom;
  for (std::size_t i = 1; i < old.size(); ++i) {
    if (old[i].stamp <= stamp) continue;
    const double share = seconds_between(std::max(stamp, old[i - 1].stamp), old[i].stamp) /
                         seconds_between(old[i - 1].stamp, old[i].stamp);
    append(old[i].stamp, new_T_old * old[i].odom_T_robot.pose, share * old[i].step_covariance);
  }
}

Odometer::State Odometer::state() const { return {own_, bias_.state()}; }

void Odometer::restore(State state) {
  const State::Own& own = state.own;
  require_sound(own.waiting.empty() || (own.started && !own.nodes.empty()),
                "readings that wait for no start");
  require_sound(own.source == Source::kNone || !own.nodes.empty(), "odometry that has not begun");
  require_sound(
      stamps_increase(own.nodes) && stamps_increase(own.rates) &&
          std::ranges::all_of(own.waiting, [](const Interval& i) { return i.from < i.to; }),
      "odometry in no order");
  require_sound(own.turned_by_gyro >= 0 && own.turned_by_wheels >= 0, "a negative count");
  require_sound(is_amount(own.turned_by_hand_rad), "turning that is no amount");
  require_sound(std::ranges::all_of(
                    own.nodes, [](const Node& node) { return finite(node.odom_T_robot.pose); }),
                "odometry that is no number");
  bias_.restore(state.bias);
  own_ = std::move(state.own);
}

}  // namespace loopstone
