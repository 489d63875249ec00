#include "simulation/reflectivity.hpp"

#include <algorithm>
#include <cmath>

namespace loopstone {
namespace {

constexpr double kWall = 300.0;
constexpr double kReflector = 3000.0;
constexpr double kHalfBrightM = 10.0;  ///< at this range an echo is half as bright
constexpr double kNoise = 0.15;        ///< standard deviation, share of the intensity
constexpr double kLeastCosine = 0.5;   ///< a strip shines back up to 60 deg off its normal
constexpr double kOnSurfaceM = 0.02;   ///< an echo so near to a reflector is of it
constexpr double kFaintest = 0.2;      ///< no echo is fainter, share of its usual intensity

bool is_on(const Reflector& reflector, const Eigen::Vector2d& point,
           const Eigen::Vector2d& direction) {
  const Eigen::Vector2d off = point - reflector.centre;
  if (reflector.radius_m > 0.0) return std::abs(off.norm() - reflector.radius_m) < kOnSurfaceM;
  if (-direction.dot(reflector.normal) < kLeastCosine) return false;
  const double out = off.dot(reflector.normal);
  const double along = off.x() * -reflector.normal.y() + off.y() * reflector.normal.x();
  return std::abs(out) < kOnSurfaceM && std::abs(along) <= 0.5 * reflector.width_m;
}

}  // namespace

float Reflectivity::intensity(const Eigen::Vector2d& origin, double bearing_rad, double range_m) {
  const double noise = std::max(kFaintest, 1.0 + kNoise * rng_.normal(0.0, 1.0));
  if (!std::isfinite(range_m)) return 0.0F;
  const Eigen::Vector2d direction(std::cos(bearing_rad), std::sin(bearing_rad));
  const Eigen::Vector2d point = origin + range_m * direction;
  const bool gleams = std::ranges::any_of(
      reflectors_, [&](const Reflector& reflector) { return is_on(reflector, point, direction); });
  const double far = range_m / kHalfBrightM;
  return static_cast<float>((gleams ? kReflector : kWall) * noise / (1.0 + far * far));
}

}  // namespace loopstone
