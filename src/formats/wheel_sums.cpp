#include "formats/wheel_sums.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace loopstone {
namespace {

/// More no robot drives; whole numbers hold differences of these.
constexpr double kMostCounts = 1e18;

}  // namespace

WheelSums::WheelSums(std::vector<WheelSpot> spots)
    : spots_(std::move(spots)), waiting_(spots_.size()), newest_(spots_.size()) {}

void WheelSums::add(std::size_t wheel, Stamp stamp, double rolled) {
  std::deque<Sample>& samples = waiting_[wheel];
  if (newest_[wheel] && stamp <= *newest_[wheel]) return;
  newest_[wheel] = stamp;
  samples.push_back({stamp, rolled});
  if (samples.size() > kMostWaiting) samples.pop_front();
}

std::vector<WheelTicks> WheelSums::take() {
  std::vector<WheelTicks> readings;
  while (!waiting_.empty() && !waiting_.front().empty()) {
    const Stamp stamp = waiting_.front().front().stamp;
    const bool is_complete = std::ranges::all_of(waiting_, [&](const auto& samples) {
      return !samples.empty() && samples.back().stamp >= stamp;
    });
    if (!is_complete) break;
    // Nobody knows how far a wheel had rolled that was told of only later.
    const bool is_known = std::ranges::all_of(
        waiting_, [&](const auto& samples) { return samples.front().stamp <= stamp; });
    if (is_known) {
      const std::array<double, 4> rolled = totals(stamp);
      std::array<std::int64_t, 4> now{};
      for (std::size_t i = 0; i < now.size(); ++i) {
        now[i] = std::llround(std::clamp(rolled[i], -kMostCounts, kMostCounts));
      }
      WheelTicks reading{.stamp = stamp};
      for (std::size_t i = 0; last_ && i < now.size(); ++i) {
        reading.counts[i] = now[i] - (*last_)[i];
      }
      last_ = now;
      readings.push_back(reading);
    }
    waiting_.front().pop_front();
    for (std::size_t wheel = 1; wheel < waiting_.size(); ++wheel) {
      while (waiting_[wheel].size() > 1 && waiting_[wheel][1].stamp <= stamp) {
        waiting_[wheel].pop_front();
      }
    }
  }
  return readings;
}

double WheelSums::at(const std::deque<Sample>& samples, Stamp stamp) {
  const auto after = std::ranges::lower_bound(samples, stamp, {}, &Sample::stamp);
  if (after->stamp == stamp || after == samples.begin()) return after->rolled;
  const auto before = std::prev(after);
  const double share = (stamp - before->stamp).seconds() / (after->stamp - before->stamp).seconds();
  return before->rolled + share * (after->rolled - before->rolled);
}

/// In the order of WheelTicks.
std::array<double, 4> WheelSums::totals(Stamp stamp) const {
  const auto mean = [&](bool is_left, WheelRow other_than) {
    double sum = 0.0;
    double wheels = 0.0;
    for (std::size_t i = 0; i < spots_.size(); ++i) {
      if (spots_[i].is_left != is_left || spots_[i].row == other_than) continue;
      sum += at(waiting_[i], stamp);
      wheels += 1.0;
    }
    return wheels > 0.0 ? std::optional(sum / wheels) : std::nullopt;
  };
  const auto of = [&](bool is_left, WheelRow row) {
    const WheelRow other = row == WheelRow::kFront ? WheelRow::kRear : WheelRow::kFront;
    const auto own = mean(is_left, other);
    return own ? own : mean(is_left, row);
  };
  return {of(false, WheelRow::kFront).value_or(0.0), of(true, WheelRow::kFront).value_or(0.0),
          of(false, WheelRow::kRear).value_or(0.0), of(true, WheelRow::kRear).value_or(0.0)};
}

}  // namespace loopstone
