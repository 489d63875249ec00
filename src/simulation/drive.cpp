#include "loopstone/simulation/drive.hpp"

#include <algorithm>
#include <cmath>

namespace loopstone {

void Drive::append(double speed_m_s, double yaw_rate_rad_s) {
  speeds_.push_back(speed_m_s);
  yaw_rates_.push_back(yaw_rate_rad_s);
  travelled_m_.push_back(travelled_m_.back() + kStep * speed_m_s);
  turned_rad_.push_back(turned_rad_.back() + kStep * yaw_rate_rad_s);
  poses_.push_back(poses_.back() * exp(Tangent2(kStep * speed_m_s, 0.0, kStep * yaw_rate_rad_s)));
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
  return poses_[a.step] *
         exp(Tangent2(a.rest_s * speeds_[a.step], 0.0, a.rest_s * yaw_rates_[a.step]));
}

double Drive::travelled_m(double time_s) const {
  const At a = at(time_s);
  return a.rest_s == 0.0 ? travelled_m_[a.step] : travelled_m_[a.step] + a.rest_s * speeds_[a.step];
}

double Drive::turned_rad(double time_s) const {
  const At a = at(time_s);
  return a.rest_s == 0.0 ? turned_rad_[a.step]
                         : turned_rad_[a.step] + a.rest_s * yaw_rates_[a.step];
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
}

}  // namespace loopstone
