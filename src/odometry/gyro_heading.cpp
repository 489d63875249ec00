#include "loopstone/odometry/gyro_heading.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace loopstone {

namespace {

constexpr Duration kMemory{10'000'000'000};
constexpr Duration kLargestGap{200'000'000};
constexpr Duration kHold{50'000'000};

}  // namespace

void GyroHeading::add(const ImuSample& sample) {
  const double rate = sample.angular_velocity_rad_s.z();
  if (!std::isfinite(rate)) return;
  if (nodes_.empty()) {
    nodes_.push_back({sample.stamp, rate, 0.0});
    return;
  }
  const Node last = nodes_.back();
  if (sample.stamp <= last.stamp) return;
  if (sample.stamp - last.stamp > kLargestGap) nodes_.clear();
  const double seconds = (sample.stamp - last.stamp).seconds();
  nodes_.push_back(
      {sample.stamp, rate, last.heading_rad + 0.5 * (last.rate_rad_s + rate) * seconds});
  while (nodes_.front().stamp < sample.stamp - kMemory) nodes_.pop_front();
}

std::optional<double> GyroHeading::heading_at(Stamp stamp) const {
  if (nodes_.empty() || stamp < nodes_.front().stamp) return {};
  const Node& newest = nodes_.back();
  if (stamp >= newest.stamp) {
    if (stamp - newest.stamp > kHold) return {};
    return newest.heading_rad + newest.rate_rad_s * (stamp - newest.stamp).seconds();
  }
  const auto after = std::upper_bound(nodes_.begin(), nodes_.end(), stamp,
                                      [](Stamp s, const Node& node) { return s < node.stamp; });
  const Node& before = *std::prev(after);
  const double span = (after->stamp - before.stamp).seconds();
  const double seconds = (stamp - before.stamp).seconds();
  const double rate = before.rate_rad_s + (after->rate_rad_s - before.rate_rad_s) * seconds / span;
  return before.heading_rad + 0.5 * (before.rate_rad_s + rate) * seconds;
}

std::optional<Stamp> GyroHeading::newest() const {
  if (nodes_.empty()) return {};
  return nodes_.back().stamp;
}

}  // namespace loopstone
