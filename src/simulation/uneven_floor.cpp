#include "simulation/uneven_floor.hpp"

#include <algorithm>
#include <cmath>

namespace loopstone {
namespace {

constexpr double kWheelBase = 0.35;      ///< between axles [m]
constexpr double kWheelTrack = 0.4;      ///< between the wheels of an axle [m]
constexpr double kSillHalfWidth = 0.05;  ///< [m]
constexpr double kRampLength = 3.0;      ///< [m]
constexpr double kLevel = 1e-5;          ///< beams flatter than this meet no floor [rad]

/// Distance from the nearest of the lines at every `period`.
double off_line(double at, double period) { return std::abs(std::remainder(at, period)); }

/// A plateau: up a ramp, level, down a ramp, level.
double plateau(double at, double period, double slope) {
  const double from_top = off_line(at, period);  // 0 in the plateau's middle, half a period below
  const double begins = 0.25 * period - 0.5 * kRampLength;
  return slope * (kRampLength - std::clamp(from_top - begins, 0.0, kRampLength));
}

}  // namespace

UnevenFloor::UnevenFloor(const RealismUneven& options, Rng rng) : options_(options) {
  for (Wave& wave : waves_) {
    const double heading = rng.uniform(0.0, 2.0 * kPi);
    const double number = 2.0 * kPi / rng.uniform(1.5, 7.0);
    wave.number = number * Eigen::Vector2d(std::cos(heading), std::sin(heading));
    // Each has its share of the square of the slope along any line: the mean over headings is half
    // of that along its own, and so is the mean over a wave.
    wave.height_m =
        2.0 * options.slope_rad / (number * std::sqrt(static_cast<double>(waves_.size())));
    wave.phase_rad = rng.uniform(0.0, 2.0 * kPi);
  }
  const auto phase = [&](double period) {
    const double y = rng.uniform(0.0, period);
    const double x = rng.uniform(0.0, period);
    return Eigen::Vector2d(x, y);
  };
  sill_phase_m_ = phase(options.sill_every_m);
  ramp_phase_m_ = phase(options.ramp_every_m);
}

double UnevenFloor::height_m(const Eigen::Vector2d& point) const {
  double height = 0.0;
  for (const Wave& wave : waves_)
    height += wave.height_m * std::sin(wave.number.dot(point) + wave.phase_rad);
  const Eigen::Vector2d at_sill = point + sill_phase_m_;
  const Eigen::Vector2d at_ramp = point + ramp_phase_m_;
  for (int axis = 0; axis < 2; ++axis) {
    const double off = off_line(at_sill[axis], options_.sill_every_m);
    height += options_.sill_m * std::max(0.0, 1.0 - off / kSillHalfWidth);
    height += plateau(at_ramp[axis], options_.ramp_every_m, options_.ramp_rad);
  }
  return height;
}

FloorTilt UnevenFloor::tilt_at(const Pose2& map_T_robot) const {
  const auto at = [&](double x, double y) { return height_m(map_T_robot * Eigen::Vector2d(x, y)); };
  const double x = 0.5 * kWheelBase;
  const double y = 0.5 * kWheelTrack;
  const double front_left = at(x, y);
  const double front_right = at(x, -y);
  const double rear_left = at(-x, y);
  const double rear_right = at(-x, -y);
  return {0.5 * (front_left + front_right - rear_left - rear_right) / kWheelBase,
          0.5 * (front_left + rear_left - front_right - rear_right) / kWheelTrack};
}

double UnevenFloor::range_m(double level_range_m, double bearing_rad, double height_m,
                            const FloorTilt& tilt) const {
  const double up =
      tilt.nose_up_rad * std::cos(bearing_rad) + tilt.left_up_rad * std::sin(bearing_rad);
  const double along = level_range_m / std::cos(up);
  if (up < -kLevel) return std::min(along, height_m / std::sin(-up));
  if (up > kLevel) return std::min(along, (options_.ceiling_m - height_m) / std::sin(up));
  return along;
}

}  // namespace loopstone
