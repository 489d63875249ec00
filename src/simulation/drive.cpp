#include "loopstone/simulation/drive.hpp"

#include <algorithm>
#include <cmath>

#include "simulation/route_planner.hpp"

namespace loopstone {

void Drive::append(double speed_m_s, double yaw_rate_rad_s) {
  speeds_.push_back(speed_m_s);
  yaw_rates_.push_back(yaw_rate_rad_s);
  travelled_m_.push_back(travelled_m_.back() + kStep * speed_m_s);
  turned_rad_.push_back(turned_rad_.back() + kStep * yaw_rate_rad_s);
  poses_.push_back(poses_.back() * exp(Tangent2(kStep * speed_m_s, 0.0, kStep * yaw_rate_rad_s)));
  if (!hands_.empty()) append_hand(Tangent2::Zero());
}

void Drive::append_hand(const Tangent2& per_s) {
  by_hand_rad_.push_back(by_hand_rad_.back() + kStep * per_s.z());
  hands_.push_back(per_s);
}

void Drive::append(const Drive& other) {
  for (std::size_t step = 0; step < other.speeds_.size(); ++step)
    append(other.speeds_[step], other.yaw_rates_[step]);
}

void Drive::carry_along(std::span<const Eigen::Vector2d> way, double yaw, double duration_s,
                        bool is_blind) {
  if (hands_.empty()) {
    hands_.assign(speeds_.size(), Tangent2::Zero());
    by_hand_rad_.assign(speeds_.size() + 1, 0.0);
  }
  const Pose2 from = last_pose();
  const double turn = wrap_angle(yaw - from.yaw);
  const auto steps = static_cast<int>(std::max(1.0, std::ceil(duration_s / kStep)));
  carries_.push_back({this->duration_s(), this->duration_s() + kStep * steps, is_blind});
  const std::vector<double> at_m = distances_along(way);
  for (int step = 1; step <= steps; ++step) {
    const double share = static_cast<double>(step) / steps;
    const Eigen::Vector2d at = point_along(way, at_m, share * at_m.back());
    const Pose2 next{at.x(), at.y(), from.yaw + share * turn};
    append_hand(log(last_pose().inverse() * next) / kStep);
    speeds_.push_back(0.0);
    yaw_rates_.push_back(0.0);
    travelled_m_.push_back(travelled_m_.back());
    turned_rad_.push_back(turned_rad_.back() + turn / steps);
    poses_.push_back(next);
  }
}

Drive::At Drive::at(double time_s) const {
  if (!(time_s > 0.0)) return {};
  const auto step = static_cast<std::size_t>(time_s / kStep);
  if (step >= speeds_.size()) return {speeds_.size(), 0.0};
  return {step, time_s - kStep * static_cast<double>(step)};
}

Pose2 Drive::pose_at(double time_s) const {
  const At a = at(time_s);
  if (a.rest_s == 0.0) return poses_[a.step];
  if (is_carried(a.step)) return poses_[a.step] * exp(Tangent2(a.rest_s * hands_[a.step]));
  return poses_[a.step] *
         exp(Tangent2(a.rest_s * speeds_[a.step], 0.0, a.rest_s * yaw_rates_[a.step]));
}

double Drive::travelled_m(double time_s) const {
  const At a = at(time_s);
  return a.rest_s == 0.0 ? travelled_m_[a.step] : travelled_m_[a.step] + a.rest_s * speeds_[a.step];
}

double Drive::turned_rad(double time_s) const {
  const At a = at(time_s);
  if (is_carried(a.step)) return turned_rad_[a.step] + a.rest_s * hands_[a.step].z();
  return a.rest_s == 0.0 ? turned_rad_[a.step]
                         : turned_rad_[a.step] + a.rest_s * yaw_rates_[a.step];
}

double Drive::turned_by_hand_rad(double time_s) const {
  if (hands_.empty()) return 0.0;
  const At a = at(time_s);
  if (!is_carried(a.step)) return by_hand_rad_[a.step];
  return by_hand_rad_[a.step] + a.rest_s * hands_[a.step].z();
}

bool Drive::is_carried(std::size_t step) const {
  return step < hands_.size() && !hands_[step].isZero(0.0);
}

double Drive::speed_m_s(double time_s) const {
  const At a = at(time_s);
  return time_s >= 0.0 && a.step < speeds_.size() ? speeds_[a.step] : 0.0;
}

void Drive::cut(double duration_s) {
  const auto steps = static_cast<std::size_t>(std::max(0.0, std::ceil(duration_s / kStep)));
  if (steps >= speeds_.size()) return;
  speeds_.resize(steps);
  yaw_rates_.resize(steps);
  poses_.resize(steps + 1);
  travelled_m_.resize(steps + 1);
  turned_rad_.resize(steps + 1);
  if (hands_.empty()) return;
  hands_.resize(steps);
  by_hand_rad_.resize(steps + 1);
  while (!carries_.empty() && carries_.back().from_s >= this->duration_s()) carries_.pop_back();
  if (!carries_.empty()) carries_.back().to_s = std::min(carries_.back().to_s, this->duration_s());
}

Drive Drive::without_first(double duration_s) const {
  const auto steps = std::min(
      speeds_.size(), static_cast<std::size_t>(std::max(0.0, std::ceil(duration_s / kStep))));
  Drive rest(poses_[steps]);
  for (std::size_t step = steps; step < speeds_.size(); ++step)
    rest.append(speeds_[step], yaw_rates_[step]);
  return rest;
}

}  // namespace loopstone
