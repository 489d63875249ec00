#include "loopstone/odometry/odometer.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {

namespace {

constexpr Duration kMemory{10'000'000'000};
constexpr Duration kGyroWait{100'000'000};        // how long a wheel reading waits for the gyro
constexpr Duration kGyroSilence{500'000'000};     // a gyro silent for so long is not waited for
constexpr Duration kLargestGyroGap{200'000'000};  // between samples that are interpolated
constexpr Duration kGyroHold{50'000'000};         // for so long a rate is taken to stay the same
constexpr Duration kStandstill{500'000'000};      // still wheels for so long: the robot stands
constexpr Duration kVelocitySpan{20'000'000};     // time over which a velocity is taken
// Counters that jump by more were reset (the base was switched off and on), not driven.
constexpr double kFastestWheel_m_s = 20.0;

double seconds_between(Stamp from, Stamp to) { return (to - from).seconds(); }

bool finite(const Pose2& pose) {
  return std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.yaw);
}

}  // namespace

Odometer::Odometer(const WheelModel& wheels, const OdometryOptions& options)
    : wheels_(wheels), options_(options) {}

void Odometer::add(const WheelTicks& ticks) {
  if (source_ == Source::kPoses) return;
  if (last_ticks_ && ticks.stamp <= last_ticks_->stamp) return;
  source_ = Source::kWheels;
  if (!started_) started_ = ticks.stamp;
  seen_until_ = std::max(seen_until_, ticks.stamp);
  if (!last_ticks_) {
    // What the first reading counted happened before we know when: only its stamp is of use.
    if (nodes_.empty()) {
      append(ticks.stamp, Pose2{}, Eigen::Matrix3d::Zero());
    } else if (nodes_.back().stamp < ticks.stamp) {  // restarted before the first reading
      append(ticks.stamp, nodes_.back().odom_T_robot.pose, Eigen::Matrix3d::Zero());
    }
    last_ticks_ = ticks;
    return;
  }
  const auto counts = counts_between(*last_ticks_, ticks, wheels_);
  Interval interval{last_ticks_->stamp, ticks.stamp, motion_of(counts, wheels_)};
  const bool was_reset =
      wheels_.counts_are_cumulative &&
      std::abs(interval.motion.distance_m) >
          kFastestWheel_m_s * std::max(0.1, seconds_between(interval.from, interval.to));
  if (was_reset) interval.motion = ArcMotion{};
  interval.still =
      !was_reset && std::all_of(counts.begin(), counts.end(), [](auto c) { return c == 0; });
  last_ticks_ = ticks;
  waiting_.push_back(interval);
  integrate_waiting(false);
}

void Odometer::add(const ImuSample& sample) {
  const double rate = sample.angular_velocity_rad_s.z();
  if (!std::isfinite(rate)) return;
  if (!rates_.empty() && sample.stamp <= rates_.back().stamp) return;
  if (source_ == Source::kPoses || options_.yaw == "wheels") return;
  if (!started_) started_ = sample.stamp;
  seen_until_ = std::max(seen_until_, sample.stamp);
  rates_.push_back({sample.stamp, rate});
  integrate_waiting(false);
  if (waiting_.empty()) forget_rates_before(sample.stamp - kLargestGyroGap);
}

void Odometer::add(const OdometryPose& pose) {
  if (source_ == Source::kWheels || !finite(pose.odom_T_robot)) return;
  if (last_pose_ && pose.stamp <= last_pose_->stamp) return;
  source_ = Source::kPoses;
  const bool restarted_before_first = !last_pose_ && !nodes_.empty();
  if (restarted_before_first) {
    odom_T_log_odom_ = nodes_.back().odom_T_robot.pose * pose.odom_T_robot.inverse();
  }
  last_pose_ = pose;
  if (counted_from_ && pose.stamp <= *counted_from_) return;
  const Pose2 odom_T_robot = odom_T_log_odom_ * pose.odom_T_robot;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  if (!nodes_.empty()) {
    const Pose2 motion = nodes_.back().odom_T_robot.pose.inverse() * odom_T_robot;
    covariance = motion_covariance(motion.translation().norm(), motion.yaw, false, options_);
  }
  append(pose.stamp, odom_T_robot, covariance);
}

void Odometer::finish() { integrate_waiting(true); }

void Odometer::integrate_waiting(bool all) {
  while (!waiting_.empty() && (all || !gyro_may_still_come(waiting_.front().to))) {
    const Interval interval = waiting_.front();
    waiting_.pop_front();
    integrate(interval);
  }
}

bool Odometer::gyro_may_still_come(Stamp stamp) const {
  if (options_.yaw == "wheels") return false;
  if (!rates_.empty() && rates_.back().stamp >= stamp) return false;
  if (seen_until_ - stamp > kGyroWait) return false;
  const Stamp last_sign = rates_.empty() ? *started_ : rates_.back().stamp;
  return seen_until_ - last_sign < kGyroSilence;
}

void Odometer::integrate(Interval interval) {
  if (!interval.still) still_since_.reset();
  if (interval.still && !still_since_) still_since_ = interval.from;

  if (counted_from_ && interval.from < *counted_from_) {
    if (interval.to <= *counted_from_) return;
    // Only the part after the restart moves the robot, at the interval's constant speed.
    const double share =
        seconds_between(*counted_from_, interval.to) / seconds_between(interval.from, interval.to);
    interval = {*counted_from_,
                interval.to,
                {share * interval.motion.distance_m, share * interval.motion.rotation_rad},
                interval.still};
  }

  const bool standing =
      options_.use_standstill && still_since_ && interval.to - *still_since_ > kStandstill;
  const bool nearest = options_.alignment == "nearest";
  const Rate* rate = nearest_rate(interval.to);
  const bool gyro = nearest ? rate != nullptr : gyro_covers(interval);
  if (gyro) {
    ++turned_by_gyro_;
  } else {
    ++turned_by_wheels_;
  }
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
    const double yaw_before = nodes_.back().odom_T_robot.pose.yaw;
    integrate_along_gyro(interval);
    const double by_wheels = interval.motion.rotation_rad;
    const double by_gyro = wrap_angle(nodes_.back().odom_T_robot.pose.yaw - yaw_before);
    turns_.ww += by_wheels * by_wheels;
    turns_.wg += by_wheels * by_gyro;
    turns_.gg += by_gyro * by_gyro;
  }
  forget_rates_before(interval.to - kLargestGyroGap);
}

std::optional<double> Odometer::wheels_with_gyro() const {
  // A turn of a radian, told in intervals of a twentieth of one.
  constexpr double kEnough = 0.05;
  if (turns_.ww < kEnough || turns_.gg < kEnough) return {};
  return turns_.wg / std::sqrt(turns_.ww * turns_.gg);
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
  for (const Rate& rate : rates_) {
    if (rate.stamp > interval.from && rate.stamp < interval.to) advance_to(rate.stamp);
  }
  advance_to(interval.to);
}

void Odometer::step(Stamp to, const ArcMotion& motion, bool yaw_from_gyro) {
  const Pose2 moved =
      options_.integration == "euler" ? integrate_euler(motion) : integrate_arc(motion);
  append(to, nodes_.back().odom_T_robot.pose * moved,
         motion_covariance(motion.distance_m, motion.rotation_rad, yaw_from_gyro, options_));
}

void Odometer::append(Stamp stamp, const Pose2& odom_T_robot,
                      const Eigen::Matrix3d& step_covariance) {
  Node node{stamp, {odom_T_robot, Eigen::Matrix3d::Zero()}, step_covariance};
  if (!nodes_.empty()) {
    const PoseWithCovariance2& before = nodes_.back().odom_T_robot;
    const PoseWithCovariance2 motion{before.pose.inverse() * odom_T_robot, step_covariance};
    node.odom_T_robot.covariance = compound(before, motion).covariance;
  }
  nodes_.push_back(node);
  while (nodes_.size() > 2 && nodes_[1].stamp < stamp - kMemory) {
    nodes_.pop_front();
    forgot_nodes_ = true;
  }
}

void Odometer::learn_bias(const Interval& interval) {
  for (const Rate& rate : rates_) {
    if (rate.stamp > interval.from && rate.stamp <= interval.to) {
      bias_.learn(rate.stamp, rate.rate_rad_s);
    }
  }
}

void Odometer::forget_rates_before(Stamp stamp) {
  while (rates_.size() > 2 && rates_[1].stamp < stamp) rates_.pop_front();
}

bool Odometer::gyro_covers(const Interval& interval) const {
  // At either end of its recording the gyro may miss a part of an interval: its nearest rate holds
  // there.
  if (rates_.empty() || rates_.front().stamp - interval.from > kGyroHold ||
      interval.to - rates_.back().stamp > kGyroHold) {
    return false;
  }
  for (std::size_t i = 1; i < rates_.size(); ++i) {
    const bool touches = rates_[i].stamp > interval.from && rates_[i - 1].stamp < interval.to;
    if (touches && rates_[i].stamp - rates_[i - 1].stamp > kLargestGyroGap) return false;
  }
  return true;
}

const Odometer::Rate* Odometer::nearest_rate(Stamp stamp) const {
  const Rate* best = nullptr;
  Duration distance = kGyroWait;
  for (const Rate& rate : rates_) {
    const Duration own = std::max(rate.stamp - stamp, stamp - rate.stamp);
    if (own < distance) {
      best = &rate;
      distance = own;
    }
  }
  return best;
}

double Odometer::rate_at(Stamp stamp) const {
  const auto after = std::lower_bound(rates_.begin(), rates_.end(), stamp,
                                      [](const Rate& rate, Stamp s) { return rate.stamp < s; });
  if (after == rates_.end()) return rates_.back().rate_rad_s;
  if (after->stamp == stamp || after == rates_.begin()) return after->rate_rad_s;
  const auto before = std::prev(after);
  const double ratio =
      seconds_between(before->stamp, stamp) / seconds_between(before->stamp, after->stamp);
  return before->rate_rad_s + ratio * (after->rate_rad_s - before->rate_rad_s);
}

std::optional<Stamp> Odometer::newest() const {
  if (nodes_.empty()) return {};
  return nodes_.back().stamp;
}

std::optional<PoseWithCovariance2> Odometer::pose_at(Stamp stamp) const {
  if (nodes_.empty()) return {};
  const Duration reach = Duration::from_seconds(options_.max_extrapolation_s);
  if (stamp < nodes_.front().stamp) {
    if (forgot_nodes_ || nodes_.front().stamp - stamp > reach) return {};
    return nodes_.front().odom_T_robot;
  }
  if (stamp > nodes_.back().stamp) {
    if (stamp - nodes_.back().stamp > reach) return {};
    return options_.alignment == "nearest" ? nodes_.back().odom_T_robot : extrapolate(stamp);
  }
  const auto after = std::lower_bound(nodes_.begin(), nodes_.end(), stamp,
                                      [](const Node& node, Stamp s) { return node.stamp < s; });
  if (after->stamp == stamp) return after->odom_T_robot;
  const auto before = std::prev(after);
  if (options_.alignment == "nearest") {
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
  const Node& last = nodes_.back();
  // The node before may be a fraction of a millisecond away; a velocity needs a longer span.
  std::size_t i = nodes_.size() - 1;
  while (i > 0 && last.stamp - nodes_[i].stamp < kVelocitySpan) --i;
  if (i + 1 == nodes_.size()) return last.odom_T_robot;
  const double ratio =
      seconds_between(last.stamp, stamp) / seconds_between(nodes_[i].stamp, last.stamp);
  const Tangent2 twist = log(nodes_[i].odom_T_robot.pose.inverse() * last.odom_T_robot.pose);
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
  for (std::size_t i = 1; i < nodes_.size() && now < to; ++i) {
    if (nodes_[i].stamp <= now) continue;
    const Stamp end = std::min(nodes_[i].stamp, to);
    const double share = seconds_between(std::max(now, nodes_[i - 1].stamp), end) /
                         seconds_between(nodes_[i - 1].stamp, nodes_[i].stamp);
    const Pose2 from_T_end = odom_T_from->pose.inverse() * pose_at(end)->pose;
    from_T_now = compound(
        from_T_now, {from_T_now.pose.inverse() * from_T_end, share * nodes_[i].step_covariance});
    now = end;
  }
  if (now < to && options_.alignment != "nearest" && to > nodes_.back().stamp) {
    const Pose2 step = nodes_.back().odom_T_robot.pose.inverse() * odom_T_to->pose;
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
  const std::deque<Node> old = std::exchange(nodes_, {});
  forgot_nodes_ = false;
  counted_from_ = stamp;
  append(stamp, odom_T_robot, Eigen::Matrix3d::Zero());
  if (!before) {
    if (last_pose_) odom_T_log_odom_ = odom_T_robot * last_pose_->odom_T_robot.inverse();
    return;
  }
  // What is known of the motion after the stamp stays true; only where it starts has changed.
  const Pose2 new_T_old = odom_T_robot * before->pose.inverse();
  odom_T_log_odom_ = new_T_old * odom_T_log_odom_;
  for (std::size_t i = 1; i < old.size(); ++i) {
    if (old[i].stamp <= stamp) continue;
    const double share = seconds_between(std::max(stamp, old[i - 1].stamp), old[i].stamp) /
                         seconds_between(old[i - 1].stamp, old[i].stamp);
    append(old[i].stamp, new_T_old * old[i].odom_T_robot.pose, share * old[i].step_covariance);
  }
}

}  // namespace loopstone
