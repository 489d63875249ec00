#include "loopstone/registration/scan_matcher.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "loopstone/geometry/angle.hpp"
#include "registration/direction_index.hpp"
#include "registration/window_search.hpp"

namespace loopstone {

namespace {

constexpr int kMinPairs = 8;
constexpr double kStepM = 2e-5;
constexpr double kStepRad = 5e-6;
constexpr double kFacingCosine = 0.5;

/// Which surfaces of the source are used, as indices with this step.
struct Fit {
  Pose2 pose;
  double explained = 0.0;
  double contradicted = 0.0;
  double total = 0.0;
  int pairs = 0;
  int iterations = 0;
  bool converged = false;
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  double squared_sum = 0.0;
  double weight_sum = 0.0;
};

void linearise(Fit& fit, const ScanView& source, const ScanView& target, std::size_t stride,
               double width_m) {
  fit.hessian.setZero();
  fit.gradient.setZero();
  fit.squared_sum = fit.weight_sum = fit.explained = fit.contradicted = fit.total = 0.0;
  fit.pairs = 0;
  const double c = std::cos(fit.pose.yaw);
  const double s = std::sin(fit.pose.yaw);
  const double inverse_width2 = 1.0 / (width_m * width_m);
  const double gate = 4.0 * width_m + 0.1;
  const int last = static_cast<int>(target.surfaces.size()) - 1;
  double h00 = 0, h01 = 0, h02 = 0, h11 = 0, h12 = 0, h22 = 0, g0 = 0, g1 = 0, g2 = 0;
  for (std::size_t i = 0; i < source.surfaces.size(); i += stride) {
    const SurfacePoint& surface = source.surfaces[i];
    fit.total += surface.weight;
    const double px = surface.position.x(), py = surface.position.y();
    const double ax = c * px - s * py, ay = s * px + c * py;
    const double x = ax + fit.pose.x, y = ay + fit.pose.y;
    const double sx = c * surface.normal.x() - s * surface.normal.y();
    const double sy = s * surface.normal.x() + c * surface.normal.y();
    const double bx = x - target.lidar.x(), by = y - target.lidar.y();
    const int at = target.by_direction[static_cast<std::size_t>(direction_bin(bx, by))];
    if (at < 0) continue;
    const SurfacePoint* best = nullptr;
    double best_distance2 = gate * gate;
    for (int j = std::max(0, at - 2); j <= std::min(last, at + 2); ++j) {
      const SurfacePoint& other = target.surfaces[static_cast<std::size_t>(j)];
      if (other.normal.x() * sx + other.normal.y() * sy < kFacingCosine) continue;
      const double dx = x - other.position.x(), dy = y - other.position.y();
      const double distance2 = dx * dx + dy * dy;
      if (distance2 < best_distance2) {
        best_distance2 = distance2;
        best = &other;
      }
    }
    if (best == nullptr) {
      // Nothing there: seen through by the target's beam (contradiction), or hidden from it (no claim).
      const SurfacePoint& seen = target.surfaces[static_cast<std::size_t>(at)];
      const double tx = seen.position.x() - target.lidar.x(), ty = seen.position.y() - target.lidar.y();
      if (bx * bx + by * by < tx * tx + ty * ty) fit.contradicted += surface.weight;
      continue;
    }
    const double nx = best->normal.x(), ny = best->normal.y();
    const double residual = nx * (x - best->position.x()) + ny * (y - best->position.y());
    const double scaled2 = residual * residual * inverse_width2;
    const double weight = surface.weight * best->weight / (1.0 + scaled2);
    const double jw = ny * ax - nx * ay;
    h00 += weight * nx * nx;
    h01 += weight * nx * ny;
    h02 += weight * nx * jw;
    h11 += weight * ny * ny;
    h12 += weight * ny * jw;
    h22 += weight * jw * jw;
    g0 += weight * residual * nx;
    g1 += weight * residual * ny;
    g2 += weight * residual * jw;
    fit.squared_sum += weight * residual * residual;
    fit.weight_sum += weight;
    if (scaled2 < 4.0) fit.explained += surface.weight;
    ++fit.pairs;
  }
  fit.hessian << h00, h01, h02, h01, h11, h12, h02, h12, h22;
  fit.gradient << g0, g1, g2;
}

void step(Fit& fit) {
  Eigen::Matrix3d damped = fit.hessian;
  damped.diagonal() += 1e-6 * fit.hessian.diagonal() + Eigen::Vector3d::Constant(1e-6);
  const Eigen::Vector3d move = -damped.ldlt().solve(fit.gradient);
  ++fit.iterations;
  if (!move.allFinite()) return;
  fit.pose = {fit.pose.x + move.x(), fit.pose.y + move.y(), wrap_angle(fit.pose.yaw + move.z())};
  fit.converged = move.head<2>().norm() < kStepM && std::abs(move.z()) < kStepRad;
}

double rank(const Fit& fit) { return (fit.explained - fit.contradicted) / std::max(1e-9, fit.total); }

}  // namespace

MatchResult match_scans(const ScanView& source, const ScanView& target,
                        const Pose2& guess_target_T_source, const ScanMatchOptions& options) {
  MatchResult result{.target_T_source = guess_target_T_source};
  const std::size_t stride = std::max<std::size_t>(1, source.surfaces.size() / 90);
  const auto candidates = search_window(source, target, guess_target_T_source, options.search_half_xy_m,
                                        options.search_half_yaw_rad, options.candidates);
  Fit best;
  double best_rank = -2.0;
  int n = 0;
  for (const Candidate& candidate : candidates) {
    Fit fit{.pose = candidate.target_T_source};
    for (const double width : {0.2, 0.2, 0.1, 0.1, 0.05}) {
      linearise(fit, source, target, stride, width);
      if (fit.pairs < kMinPairs) break;
      step(fit);
    }
    linearise(fit, source, target, stride, 0.05);
    const double r = rank(fit);
    if (r > best_rank) { best_rank = r; best = fit; }
    if (best_rank > 0.9) break;
    ++n;
  }
  for (int i = 0; i < options.max_iterations; ++i) {
    linearise(best, source, target, 1, options.kernel_width_m);
    if (best.pairs < kMinPairs) break;
    step(best);
    if (best.converged) break;
  }
  result.target_T_source = best.pose;
  result.iterations = best.iterations;
  result.score = best.explained / std::max(1e-9, best.total);
  result.pairs = best.pairs;
  result.rmse_m = std::sqrt(best.squared_sum / std::max(1e-9, best.weight_sum));
  result.covariance = 1e-4 * (best.hessian + 1e-6 * Eigen::Matrix3d::Identity()).inverse();
  result.status = best.converged ? MatchStatus::kConverged : MatchStatus::kNotConverged;
  return result;
}

}  // namespace loopstone
