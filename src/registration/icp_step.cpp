#include "registration/icp_step.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "loopstone/geometry/line_alignment.hpp"
#include "loopstone/geometry/rigid_alignment.hpp"

namespace loopstone {

namespace {

/// A Gauss-Newton step turns no farther: beyond, the linearised turn is wrong anyway.
constexpr double kLongestTurnRad = 0.5;
constexpr double kLeastArmM = 1e-9;

template <int kDimension>
using Pose = typename RigidMotion<kDimension>::Pose;

template <int kDimension>
Pose<kDimension> step_to_points(std::span<const IcpPair<kDimension>> pairs,
                                const Pose<kDimension>& pose) {
  using Vector = typename RigidMotion<kDimension>::Vector;
  const Vector translation = RigidMotion<kDimension>::translation(pose);
  std::vector<Vector> source;
  std::vector<Vector> target;
  std::vector<double> weights;
  source.reserve(pairs.size());
  target.reserve(pairs.size());
  weights.reserve(pairs.size());
  for (const auto& pair : pairs) {
    source.push_back(pair.source);
    target.push_back(pair.arm + translation - pair.offset);
    weights.push_back(pair.weight);
  }
  return to_pose(align_rigidly<kDimension>(source, target, weights));
}

/// Nothing when the lines leave a motion open.
bool step_to_lines(std::span<const IcpPair<2>> pairs, Pose2& pose) {
  std::vector<PointOnLine> lines;
  lines.reserve(pairs.size());
  for (const auto& pair : pairs) {
    if (pair.weight <= 0.0) continue;
    // About the source's origin, on the target's axes: the motion that is left is small.
    lines.push_back({pair.arm, pair.arm - pair.offset, pair.normal, pair.weight});
  }
  const RigidAlignment<2> motion = align_to_lines(lines);
  if (!motion.unique) return false;
  pose = {pose.x + motion.translation.x(), pose.y + motion.translation.y(),
          wrap_angle(pose.yaw + std::atan2(motion.rotation(1, 0), motion.rotation(0, 0)))};
  return true;
}

}  // namespace

template <int kDimension>
IcpEquations<kDimension> equations_of(std::span<const IcpPair<kDimension>> pairs,
                                      IcpMetric metric) {
  using Motion = RigidMotion<kDimension>;
  using Tangent = typename Motion::Tangent;
  using Vector = typename Motion::Vector;
  IcpEquations<kDimension> result;
  for (const auto& pair : pairs) {
    if (pair.weight <= 0.0) continue;
    const auto jacobian = Motion::point_jacobian(pair.arm);
    if (metric == IcpMetric::kGicp) {
      // J^T M J with M = a (1 + b (n n^T + m m^T) + c (n m^T + m n^T)) is a J^T J + u p^T + v q^T.
      const Vector& n = pair.normal;
      const Vector& m = pair.turned_normal;
      const GicpWeight weight(n.dot(m));
      const double scale = pair.weight * weight.scale;
      const Tangent u = jacobian.transpose() * n;
      const Tangent v = jacobian.transpose() * m;
      const Tangent p = (scale * weight.same) * u + (scale * weight.cross) * v;
      const Tangent q = (scale * weight.same) * v + (scale * weight.cross) * u;
      result.information.noalias() += u * p.transpose();
      result.information.noalias() += v * q.transpose();
      result.information.noalias() += scale * (jacobian.transpose() * jacobian);
      result.gradient += n.dot(pair.offset) * p + m.dot(pair.offset) * q +
                         scale * (jacobian.transpose() * pair.offset);
    } else if (metric == IcpMetric::kPoint) {
      result.information.noalias() += pair.weight * (jacobian.transpose() * jacobian);
      result.gradient.noalias() += pair.weight * (jacobian.transpose() * pair.offset);
    } else {
      const Tangent across = jacobian.transpose() * pair.normal;
      const Tangent weighted = pair.weight * across;
      result.information.noalias() += weighted * across.transpose();
      result.gradient += pair.normal.dot(pair.offset) * weighted;
    }
  }
  set_extent(result, pairs);
  return result;
}

template <int kDimension>
void set_extent(IcpEquations<kDimension>& equations, std::span<const IcpPair<kDimension>> pairs) {
  double total = 0.0;
  double squared_arms = 0.0;
  typename RigidMotion<kDimension>::Vector sum = RigidMotion<kDimension>::Vector::Zero();
  for (const auto& pair : pairs) {
    total += pair.weight;
    sum += pair.weight * pair.arm;
    squared_arms += pair.weight * pair.arm.squaredNorm();
  }
  if (total > 0.0) {
    sum /= total;
    squared_arms /= total;
  }
  equations.centre = sum;
  equations.arm_m = std::sqrt(std::max(squared_arms - sum.squaredNorm(), 0.0)) + kLeastArmM;
}

template <int kDimension>
Pose<kDimension> step(std::span<const IcpPair<kDimension>> pairs, IcpMetric metric,
                      const Pose<kDimension>& target_T_source, double longest_step_m) {
  using Motion = RigidMotion<kDimension>;
  constexpr int kTurns = Motion::kDof - kDimension;
  if (metric == IcpMetric::kPoint) {
    return step_to_points<kDimension>(pairs, target_T_source);
  }
  const IcpEquations<kDimension> equations = equations_of(pairs, metric);
  const Observability<kDimension> observability = equations.observability();
  if constexpr (kDimension == 2) {
    if (metric == IcpMetric::kLine && observability.complete()) {
      Pose2 pose = target_T_source;
      if (step_to_lines(pairs, pose)) return pose;
    }
  }
  typename Motion::Tangent motion = observability.solve(equations.gradient);
  // The shift is judged at the middle of the points, not at the source's origin, which may be far
  // away.
  const typename Motion::Tangent at_centre = observability.to_scaled * motion;
  const double shift_m = at_centre.template head<kDimension>().norm();
  const double turn_rad = motion.template tail<kTurns>().norm();
  const double excess = std::max(shift_m / longest_step_m, turn_rad / kLongestTurnRad);
  if (excess > 1.0) motion /= excess;
  return Motion::moved(target_T_source, motion);
}

template IcpEquations<2> equations_of<2>(std::span<const IcpPair<2>>, IcpMetric);
template IcpEquations<3> equations_of<3>(std::span<const IcpPair<3>>, IcpMetric);
template void set_extent<2>(IcpEquations<2>&, std::span<const IcpPair<2>>);
template void set_extent<3>(IcpEquations<3>&, std::span<const IcpPair<3>>);
template Pose2 step<2>(std::span<const IcpPair<2>>, IcpMetric, const Pose2&, double);
template Pose3 step<3>(std::span<const IcpPair<3>>, IcpMetric, const Pose3&, double);

}  // namespace loopstone
