#include "formats/wheel_stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/odometry/odometer.hpp"

namespace loopstone {
namespace {

std::vector<WheelSpot> spots_of(const WheelPlan& plan) {
  std::vector<WheelSpot> spots;
  for (const PlannedWheel& wheel : plan.wheels) spots.push_back(wheel.spot);
  return spots;
}

}  // namespace

WheelStream::WheelStream(const WheelPlan& plan, const Recording& recording,
                         const TopicSurvey& survey)
    : plan_(&plan),
      messages_(recording, survey),
      counts_a_turn_(plan.wheels.size(), 0.0),
      most_per_second_(kOdometer.fastest_wheel_m_s / plan.model.metres_per_count),
      sums_(spots_of(plan)) {
  for (const PlannedWheel& wheel : plan.wheels) {
    if (wheel.field.unit == WheelUnit::kCounts) {
      wheels_.emplace_back(WheelCount(wheel.field.bits, plan.counts_are_cumulative));
    } else {
      wheels_.emplace_back(WheelAngle(most_per_second_ * kRadiansPerCount));
    }
  }
}

Stamp WheelStream::read(const RecordedMessage& message, std::size_t topic) {
  told_ = &messages_.decode(message, topic);
  topic_ = topic;
  return told_->stamp.value_or(Stamp{});
}

std::optional<std::size_t> WheelStream::place_of(const ToldWheel& told) const {
  for (std::size_t i = 0; i < plan_->wheels.size(); ++i) {
    const PlannedWheel& wheel = plan_->wheels[i];
    if (wheel.topic == topic_ && wheel.name == told.name && wheel.field.path == told.field.path) {
      return i;
    }
  }
  return std::nullopt;
}

std::vector<WheelTicks> WheelStream::add(Stamp stamp) {
  std::vector<std::size_t> taken;
  for (const ToldWheel& told : told_->wheels) {
    const auto place = place_of(told);
    if (!place || (!told.position && !told.speed)) continue;
    take(*place, told, stamp);
    taken.push_back(*place);
  }
  for (const std::size_t place : taken) {
    const auto* const angle = std::get_if<WheelAngle>(&wheels_[place]);
    if (angle != nullptr && angle->needs_speed()) by_speed_ = true;
  }
  for (const std::size_t place : taken) sums_.add(place, stamp, rolled(place));
  return sums_.take();
}

void WheelStream::take(std::size_t place, const ToldWheel& told, Stamp stamp) {
  if (auto* const angle = std::get_if<WheelAngle>(&wheels_[place])) {
    angle->add(stamp, told.position, told.speed);
    return;
  }
  double& counts_a_turn = counts_a_turn_[place];
  if (told.counts_a_turn > 0.0) counts_a_turn = told.counts_a_turn;
  const double most = counts_a_turn > 0.0
                          ? most_per_second_ * kRadiansPerCount / (2.0 * kPi) * counts_a_turn
                          : most_per_second_;
  constexpr double kMostCount = 0x1p62;  // a whole number holds it
  const double count = std::clamp(told.position.value_or(0.0), -kMostCount, kMostCount);
  std::get<WheelCount>(wheels_[place]).add(stamp, std::llround(count), most);
}

/// In counts of the readings.
double WheelStream::rolled(std::size_t place) const {
  if (const auto* const angle = std::get_if<WheelAngle>(&wheels_[place])) {
    return (by_speed_ ? angle->by_speed_rad() : angle->by_position_rad()) / kRadiansPerCount;
  }
  const auto total = static_cast<double>(std::get<WheelCount>(wheels_[place]).total());
  if (counts_a_turn_[place] == 0.0) return total;
  return total / counts_a_turn_[place] * 2.0 * kPi / kRadiansPerCount;
}

std::vector<std::string> WheelStream::notes() const {
  std::int64_t resets = 0;
  for (const Wheel& wheel : wheels_) {
    resets += std::visit([](const auto& one) { return one.resets(); }, wheel);
  }
  std::vector<std::string> notes;
  if (resets > 0) {
    notes.push_back(fmt::format(
        "wheels: {} jumps that no wheel makes were left out: a driver began anew", resets));
  }
  const bool has_positions = plan_->wheels.front().field.unit == WheelUnit::kRadians;
  if (by_speed_ && has_positions) {
    notes.emplace_back("wheels: their positions are not told or stand still; their speeds count");
  }
  return notes;
}

}  // namespace loopstone
