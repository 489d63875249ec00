#include "registration/scan_fit.hpp"

#include <algorithm>
#include <cmath>

#include "registration/direction_index.hpp"
#include "registration/line_equations.hpp"

namespace loopstone {

namespace {

/// Surfaces whose normals differ by more than 60 deg are different surfaces.
constexpr float kFacingCosine = 0.5F;
/// Neighbours on both sides of the surface in a point's direction that may be nearer.
constexpr int kReach = 2;
/// Pairs are no farther apart than this, and four widths of the kernel.
constexpr double kGateM = 0.1;
constexpr double kGateWidths = 4.0;
/// A residual within so many widths is explained.
constexpr double kExplainedWidths = 2.0;
/// Along a wall seen at a grazing angle a range says more about the wall's place than its noise and
/// the beam's width allow.
constexpr double kLeastCosine = 0.3;
constexpr double kLeastSigmaM = 0.002;

/// A source surface at a pose, on the target's axes.
struct Moved {
  double arm_x;
  double arm_y;
  double x;
  double y;
  float normal_x;
  float normal_y;
};

class Mover {
 public:
  explicit Mover(const Pose2& pose)
      : cosine_(std::cos(pose.yaw)), sine_(std::sin(pose.yaw)), x_(pose.x), y_(pose.y) {}

  [[nodiscard]] Moved operator()(const SurfacePoint& surface) const {
    const double px = surface.position.x();
    const double py = surface.position.y();
    const double nx = surface.normal.x();
    const double ny = surface.normal.y();
    const double arm_x = cosine_ * px - sine_ * py;
    const double arm_y = sine_ * px + cosine_ * py;
    return {arm_x,
            arm_y,
            arm_x + x_,
            arm_y + y_,
            static_cast<float>(cosine_ * nx - sine_ * ny),
            static_cast<float>(sine_ * nx + cosine_ * ny)};
  }

 private:
  double cosine_;
  double sine_;
  double x_;
  double y_;
};

/// The surface of the target that lies in the direction of a point; -1: none.
int in_direction_of(const ScanView& target, const Moved& point) {
  return target.by_direction[static_cast<std::size_t>(
      direction_bin(point.x - target.lidar.x(), point.y - target.lidar.y()))];
}

/// The nearest surface around `at` that faces like the point, within the gate; -1: none.
int partner_of(const ScanView& target, const Moved& point, int at, double gate_m) {
  const int last = std::min(static_cast<int>(target.surfaces.size()) - 1, at + kReach);
  int best = -1;
  double best_distance2 = gate_m * gate_m;
  for (int j = std::max(0, at - kReach); j <= last; ++j) {
    const SurfacePoint& surface = target.surfaces[static_cast<std::size_t>(j)];
    const double dx = point.x - surface.position.x();
    const double dy = point.y - surface.position.y();
    const double distance2 = dx * dx + dy * dy;
    if (distance2 >= best_distance2) continue;
    if (surface.normal.x() * point.normal_x + surface.normal.y() * point.normal_y < kFacingCosine)
      continue;
    best_distance2 = distance2;
    best = j;
  }
  return best;
}

/// Whether the target's beam to a surface passed the point, that is, ended behind it.
bool seen_through(const ScanView& target, const Moved& point, int at) {
  const SurfacePoint& surface = target.surfaces[static_cast<std::size_t>(at)];
  const double point_x = point.x - target.lidar.x();
  const double point_y = point.y - target.lidar.y();
  const double end_x = surface.position.x() - target.lidar.x();
  const double end_y = surface.position.y() - target.lidar.y();
  return point_x * point_x + point_y * point_y < end_x * end_x + end_y * end_y;
}

/// A surface as the returns that it was fitted to: how they spread, seen along the normal, in
/// ranges' variance.
struct Returns {
  double cosine2;  ///< of the angle of incidence: a range's noise along the normal
  double density;  ///< returns per metre of surface
};

Returns returns_at(const ScanView& view, const Eigen::Vector2d& position,
                   const Eigen::Vector2d& normal) {
  const Eigen::Vector2d beam = position - view.lidar;
  const double range2 = std::max(beam.squaredNorm(), 1e-6);
  const double cosine = std::max(std::abs(normal.dot(beam)) / std::sqrt(range2), kLeastCosine);
  return {cosine * cosine, cosine / (std::sqrt(range2) * view.beam_spacing_rad)};
}

}  // namespace

ScanEquations scan_equations(const ScanView& source, const ScanView& target,
                             const Pose2& target_T_source, const FitScale& scale) {
  ScanEquations sum;
  const Mover move(target_T_source);
  const double inverse_width2 = 1.0 / (scale.width_m * scale.width_m);
  const double gate_m = kGateWidths * scale.width_m + kGateM;
  Agreement& agreement = sum.agreement;
  LineEquations equations;
  for (std::size_t i = 0; i < source.surfaces.size(); i += scale.stride) {
    const SurfacePoint& surface = source.surfaces[i];
    const Moved point = move(surface);
    const int at = in_direction_of(target, point);
    if (at < 0) {
      agreement.hidden += surface.weight;
      continue;
    }
    const int partner = partner_of(target, point, at, gate_m);
    if (partner < 0) {
      (seen_through(target, point, at) ? agreement.contradicted : agreement.hidden) +=
          surface.weight;
      continue;
    }
    const SurfacePoint& line = target.surfaces[static_cast<std::size_t>(partner)];
    const double nx = line.normal.x();
    const double ny = line.normal.y();
    const double residual = nx * (point.x - line.position.x()) + ny * (point.y - line.position.y());
    const double scaled2 = residual * residual * inverse_width2;
    const double weight = surface.weight * line.weight / (1.0 + scaled2);
    equations.add(nx, ny, point.arm_x, point.arm_y, residual, weight);
    sum.squared_sum += weight * residual * residual;
    sum.weight_sum += weight;
    ++sum.pairs;
    (scaled2 < kExplainedWidths * kExplainedWidths ? agreement.explained : agreement.mismatched) +=
        surface.weight;
  }
  sum.hessian = equations.hessian();
  sum.gradient = equations.gradient();
  return sum;
}

ScanKnowledge scan_knowledge(const ScanView& source, const ScanView& target,
                             const Pose2& target_T_source, const FitScale& scale) {
  ScanKnowledge result;
  Eigen::Vector2d arm_sum = Eigen::Vector2d::Zero();
  double arm_squares = 0.0;
  double weight_sum = 0.0;
  const Mover move(target_T_source);
  const double inverse_width2 = 1.0 / (scale.width_m * scale.width_m);
  double squared = 0.0;
  double expected = 0.0;
  for (std::size_t i = 0; i < source.surfaces.size(); ++i) {
    const SurfacePoint& surface = source.surfaces[i];
    const Moved point = move(surface);
    const int at = in_direction_of(target, point);
    if (at < 0) continue;
    const int partner = partner_of(target, point, at, kGateM);
    if (partner < 0) continue;
    const SurfacePoint& line = target.surfaces[static_cast<std::size_t>(partner)];
    const Eigen::Vector2d normal = line.normal.cast<double>();
    const double residual =
        normal.dot(Eigen::Vector2d(point.x, point.y) - line.position.cast<double>());
    const double weight =
        surface.weight * line.weight / (1.0 + residual * residual * inverse_width2);

    const Returns ours =
        returns_at(source, surface.position.cast<double>(), surface.normal.cast<double>());
    const Returns theirs = returns_at(target, Eigen::Vector2d(point.x, point.y), normal);
    // The stretch of surface that this point stands for, up to the next one.
    const double stretch =
        i + 1 < source.surfaces.size()
            ? std::clamp<double>((source.surfaces[i + 1].position - surface.position).norm(),
                                 source.surface_spacing_m, 3.0 * source.surface_spacing_m)
            : source.surface_spacing_m;
    // Each return counts once, however many fitted lines it takes part in.
    const double variance = ours.cosine2 / std::max(1.0, stretch * ours.density) +
                            theirs.cosine2 / (stretch * theirs.density);
    const double nw = normal.y() * point.arm_x - normal.x() * point.arm_y;
    const Eigen::Vector3d jacobian(normal.x(), normal.y(), nw);
    result.hessian.noalias() += weight * jacobian * jacobian.transpose();
    result.noise.noalias() += weight * weight * variance * jacobian * jacobian.transpose();
    const Eigen::Vector2d arm(point.arm_x, point.arm_y);
    arm_sum += weight * arm;
    arm_squares += weight * arm.squaredNorm();
    weight_sum += weight;
    // But the residual is between two fitted lines, each the mean of its support.
    squared += weight * residual * residual;
    expected += weight * (ours.cosine2 / (1.0 + 2.0 * source.support_m * ours.density) +
                          theirs.cosine2 / (1.0 + 2.0 * target.support_m * theirs.density));
  }
  if (!(expected > 0.0)) return result;
  result.noise *= std::max(kLeastSigmaM * kLeastSigmaM, squared / expected);
  result.centre = arm_sum / weight_sum;
  result.arm_m = std::sqrt(std::max(arm_squares / weight_sum - result.centre.squaredNorm(), 1e-6));
  return result;
}

}  // namespace loopstone
