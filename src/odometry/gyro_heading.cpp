#include "loopstone/odometry/gyro_heading.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "loopstone/base/sound_state.hpp"

namespace loopstone {

namespace {

constexpr Duration kMemory = Duration::from_milliseconds(kGyroHeading.memory_ms);
constexpr Duration kLargestGap = Duration::from_milliseconds(kGyroHeading.largest_gap_ms);
constexpr Duration kHold = Duration::from_milliseconds(kGyroHeading.hold_ms);

}  // namespace

void GyroHeading::add(const ImuSample& sample) {
  const double rate = sample.angular_velocity_rad_s.z();
  if (!std::isfinite(rate)) return;
  if (state_.nodes.empty()) {
    state_.nodes.push_back({sample.stamp, rate, 0.0});
    return;
  }
  const Node last = state_.nodes.back();
  if (sample.stamp <= last.stamp) return;
  if (sample.stamp - last.stamp > kLargestGap) state_.nodes.clear();
  const double seconds = (sample.stamp - last.stamp).seconds();
  state_.nodes.push_back(
      {sample.stamp, rate, last.heading_rad + 0.5 * (last.rate_rad_s + rate) * seconds});
  while (state_.nodes.front().stamp < sample.stamp - kMemory) state_.nodes.pop_front();
}

std::optional<double> GyroHeading::heading_at(Stamp stamp) const {
  if (state_.nodes.empty() || stamp < state_.nodes.front().stamp) return {};
  const Node& newest = state_.nodes.back();
  if (stamp >= newest.stamp) {
    if (stamp - newest.stamp > kHold) return {};
    return newest.heading_rad + newest.rate_rad_s * (stamp - newest.stamp).seconds();
  }
  const auto after = std::upper_bound(state_.nodes.begin(), state_.nodes.end(), stamp,
                                      [](Stamp s, const Node& node) { return s < node.stamp; });
  const Node& before = *std::prev(after);
  const double span = (after->stamp - before.stamp).seconds();
  const double seconds = (stamp - before.stamp).seconds();
  const double rate = before.rate_rad_s + (after->rate_rad_s - before.rate_rad_s) * seconds / span;
  return before.heading_rad + 0.5 * (before.rate_rad_s + rate) * seconds;
}

std::optional<Stamp> GyroHeading::newest() const {
  if (state_.nodes.empty()) return {};
  return state_.nodes.back().stamp;
}

void GyroHeading::restore(State state) {
  const Node* before = nullptr;
  for (const Node& node : state.nodes) {
    require_sound(before == nullptr || node.stamp > before->stamp, "gyro samples in no order");
    require_sound(std::isfinite(node.rate_rad_s) && std::isfinite(node.heading_rad),
                  "a gyro sample that is no number");
    before = &node;
  }
  state_ = std::move(state);
}

}  // namespace loopstone
