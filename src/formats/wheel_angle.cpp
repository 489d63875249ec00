#include "formats/wheel_angle.hpp"

#include <algorithm>
#include <cmath>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/odometry/differential_drive.hpp"
#include "loopstone/odometry/odometer.hpp"

namespace loopstone {
namespace {

constexpr double kTurn = 2.0 * kPi;
/// By so much positions of drivers that begin again at a turn reach beyond it.
constexpr double kBeyondRad = 1e-3;
/// Positions that stand still while the wheel turns by more are no positions.
constexpr double kStillRad = 0.2;
/// Over a longer gap nobody knows how fast a wheel turned.
constexpr double kLongestGapS = 2.0;

/// So that sums of counts stay whole numbers.
constexpr double kMostCounts = 0x1p60;

/// Stamps are not as good as the speed that a shorter step would have.
double at_least(double seconds) { return std::max(seconds, kOdometer.shortest_reset_s); }

std::optional<double> number(std::optional<double> value) {
  return value && std::isfinite(*value) ? value : std::nullopt;
}

}  // namespace

void WheelAngle::add(Stamp stamp, std::optional<double> position_rad,
                     std::optional<double> speed_rad_s) {
  position_rad = number(position_rad);
  speed_rad_s = number(speed_rad_s);
  if (last_ && stamp <= *last_) return;
  const double seconds = last_ ? (stamp - *last_).seconds() : 0.0;
  const std::optional<double> by_speed_rad = turned_by_speed(speed_rad_s, seconds);
  if (position_rad) add_position(*position_rad, seconds, by_speed_rad);
  by_speed_rad_ += by_speed_rad.value_or(0.0);
  farthest_by_speed_rad_ = std::max(farthest_by_speed_rad_, std::abs(by_speed_rad_));
  speed_rad_s_ = speed_rad_s;
  last_ = stamp;
}

/// By the mean of the speeds at both ends.
std::optional<double> WheelAngle::turned_by_speed(std::optional<double> speed_rad_s,
                                                  double seconds) const {
  if (!last_ || !speed_rad_s || !speed_rad_s_ || seconds > kLongestGapS) return std::nullopt;
  const double turned_rad = 0.5 * (*speed_rad_s_ + *speed_rad_s) * seconds;
  if (std::abs(turned_rad) > most_rad_s_ * at_least(seconds)) return std::nullopt;
  return turned_rad;
}

void WheelAngle::add_position(double position_rad, double seconds,
                              std::optional<double> by_speed_rad) {
  if (!position_rad_) {
    lowest_rad_ = highest_rad_ = position_rad;
    position_rad_ = position_rad;
    return;
  }
  lowest_rad_ = std::min(lowest_rad_, position_rad);
  highest_rad_ = std::max(highest_rad_, position_rad);
  const double expected_rad = by_speed_rad.value_or(rate_rad_s_ * seconds);
  double step_rad = unwrapped(position_rad - *position_rad_, expected_rad);
  if (std::abs(step_rad) > most_rad_s_ * at_least(seconds)) {
    ++resets_;
    step_rad = by_speed_rad.value_or(0.0);
    lowest_rad_ = highest_rad_ = position_rad;
  }
  if (position_rad != *position_rad_) moved_ = true;
  by_position_rad_ += step_rad;
  rate_rad_s_ = seconds > 0.0 ? step_rad / seconds : 0.0;
  position_rad_ = position_rad;
}

/// A step of more than half a turn, of positions that never left a turn, is that or its complement:
/// whichever is nearer to what was expected.
double WheelAngle::unwrapped(double step_rad, double expected_rad) const {
  const bool about_zero = lowest_rad_ >= -kPi - kBeyondRad && highest_rad_ <= kPi + kBeyondRad;
  const bool from_zero = lowest_rad_ >= -kBeyondRad && highest_rad_ <= kTurn + kBeyondRad;
  if (std::abs(step_rad) <= kPi || (!about_zero && !from_zero)) return step_rad;
  const double other_rad = step_rad > 0.0 ? step_rad - kTurn : step_rad + kTurn;
  return std::abs(other_rad - expected_rad) < std::abs(step_rad - expected_rad) ? other_rad
                                                                                : step_rad;
}

bool WheelAngle::needs_speed() const {
  if (!position_rad_) return true;
  return !moved_ && farthest_by_speed_rad_ > kStillRad;
}

void WheelCount::add(Stamp stamp, std::int64_t count, double most_per_second) {
  if (last_ && stamp <= *last_) return;
  if (last_) {
    const std::int64_t step = is_cumulative_ ? count_difference(count_, count, bits_) : count;
    const double most = most_per_second * at_least((stamp - *last_).seconds());
    const double end = std::abs(static_cast<double>(total_)) + std::abs(static_cast<double>(step));
    if (std::abs(static_cast<double>(step)) > most || end > kMostCounts) {
      ++resets_;
    } else {
      total_ += step;
    }
  }
  count_ = count;
  last_ = stamp;
}

}  // namespace loopstone
