#include "loopstone/registration/correlative_match.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "geometry/symmetric_matrix.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/rigid_motion.hpp"
#include "registration/lattice_search.hpp"
#include "registration/observability.hpp"
#include "registration/score_volume.hpp"

namespace loopstone {

namespace {

/// Bilinear between the centres of cells.
double value_at(const MaxPyramid& target, const Eigen::Vector2d& point) {
  const GridFrame& frame = target.frame();
  const double x = (point.x() - frame.origin.x()) / frame.resolution - 0.5;
  const double y = (point.y() - frame.origin.y()) / frame.resolution - 0.5;
  const int c = floor_to_int(x);
  const int r = floor_to_int(y);
  const double right = x - c;
  const double up = y - r;
  const double low = (1.0 - right) * target.bound(0, c, r) + right * target.bound(0, c + 1, r);
  const double high =
      (1.0 - right) * target.bound(0, c, r + 1) + right * target.bound(0, c + 1, r + 1);
  return (1.0 - up) * low + up * high;
}

/// The score at any pose, in points on a surface.
double smooth_score(std::span<const Eigen::Vector2d> source, const MaxPyramid& target,
                    const Pose2& pose) {
  const Eigen::Matrix2d rotation = pose.rotation();
  const Eigen::Vector2d translation = pose.translation();
  double sum = 0.0;
  for (const auto& point : source) {
    const Eigen::Vector2d moved = rotation * point + translation;
    sum += value_at(target, moved) - kUnknown;
  }
  return sum / (kSurface - kUnknown);
}

/// The parabola through the scores around a pose, in steps: score + g.x + x.H.x / 2.
struct Parabola {
  Eigen::Vector3d gradient;
  Eigen::Matrix3d curvature;
};

Parabola parabola_at(std::span<const Eigen::Vector2d> source, const MaxPyramid& target,
                     const Pose2& pose, const Eigen::Vector3d& step) {
  const auto score = [&](const Eigen::Vector3d& steps) {
    return smooth_score(source, target, RigidMotion<2>::moved(pose, steps.cwiseProduct(step)));
  };
  Parabola fit;
  const double middle = score(Eigen::Vector3d::Zero());
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d along = Eigen::Vector3d::Unit(i);
    const double ahead = score(along);
    const double behind = score(-along);
    fit.gradient(i) = 0.5 * (ahead - behind);
    fit.curvature(i, i) = ahead + behind - 2.0 * middle;
    for (int j = 0; j < i; ++j) {
      const Eigen::Vector3d across = Eigen::Vector3d::Unit(j);
      fit.curvature(i, j) = 0.25 * (score(along + across) + score(-along - across) -
                                    score(along - across) - score(across - along));
      fit.curvature(j, i) = fit.curvature(i, j);
    }
  }
  return fit;
}

/// The inverse of minus the curvature, in steps, along the directions where there is one; nothing
/// along the others.
struct Peak {
  Eigen::Matrix3d directions;
  Eigen::Vector3d information;  // ascending, at least 0
};

Peak peak_of(const Parabola& fit) {
  const auto eigen = symmetric_eigen(Eigen::Matrix3d(-fit.curvature));
  return {eigen.vectors, eigen.values.cwiseMax(0.0)};
}

struct Refined {
  Pose2 pose;
  Peak peak;
};

/// Newton's steps on the smooth score, none of them longer than half a step of the lattice and all
/// together within one.
Refined refined(std::span<const Eigen::Vector2d> source, const MaxPyramid& target,
                const Pose2& start, const Eigen::Vector3d& lattice_step) {
  constexpr int kIterations = 6;
  constexpr double kFlat = 0.01;  // share of the best direction's curvature that counts as none
  const Eigen::Vector3d step = 0.5 * lattice_step;
  Pose2 pose = start;
  double score = smooth_score(source, target, pose);
  Parabola fit = parabola_at(source, target, pose, step);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const Peak peak = peak_of(fit);
    Eigen::Vector3d along = peak.directions.transpose() * fit.gradient;
    for (int i = 0; i < 3; ++i) {
      along(i) =
          peak.information(i) > kFlat * peak.information(2) ? along(i) / peak.information(i) : 0.0;
    }
    Eigen::Vector3d move = peak.directions * along;
    const double longest = move.cwiseAbs().maxCoeff();
    if (longest > 1.0) move /= longest;
    const Pose2 next = RigidMotion<2>::moved(pose, move.cwiseProduct(step));
    const double next_score = smooth_score(source, target, next);
    const Eigen::Vector3d gone =
        RigidMotion<2>::difference(next, start).cwiseQuotient(lattice_step);
    if (!(next_score > score) || gone.cwiseAbs().maxCoeff() > 1.0) break;
    pose = next;
    score = next_score;
    fit = parabola_at(source, target, pose, step);
    if (longest < 0.01) break;
  }
  // The width of the peak is that of its lattice neighbourhood: half steps see the corners of
  // single cells.
  return {pose, peak_of(parabola_at(source, target, pose, lattice_step))};
}

/// Of one lattice pose: the inverse curvature, but no more than the spread of a step.
Eigen::Matrix3d covariance_within_step(const Peak& peak, const Eigen::Vector3d& step,
                                       double evidence) {
  constexpr double kUniform = 12.0;  // a step's variance is 1 / 12
  Eigen::Matrix3d information =
      evidence * peak.directions * peak.information.asDiagonal() * peak.directions.transpose();
  information.diagonal().array() += kUniform;
  return step.asDiagonal() * information.inverse() * step.asDiagonal();
}

/// A ridge: along it the score changes next to nothing, or the likely poses reach over several
/// cells.
bool is_ridge(const Peak& peak, const ScoreVolume& volume) {
  constexpr double kFlat = 0.01;
  constexpr double kCells = 2.0;
  const auto spread = symmetric_eigen(Eigen::Matrix2d(volume.covariance.topLeftCorner<2, 2>()));
  return peak.information(0) <= kFlat * peak.information(2) ||
         spread.values(1) > kCells * kCells * volume.step.x() * volume.step.x();
}

}  // namespace

CorrelativeMatch match_correlative(std::span<const Eigen::Vector2d> source,
                                   const MaxPyramid& target, const SearchWindow& window,
                                   const CorrelativeMatchOptions& options) {
  CorrelativeMatch result;
  MatchResult& match = result.match;
  match.target_T_source = window.centre;
  if (source.empty()) return result;
  LatticeSearch search(source, target, window);
  const SearchResult best = search.best(options.min_score);
  match.iterations = static_cast<int>(best.evaluations);
  if (!best.found) return result;

  // Elsewhere: whatever scores half as much as the best.
  if (window.half_xy_m > 0.5 * options.distinct_m ||
      window.half_yaw_rad > 0.5 * options.distinct_rad) {
    const SearchResult second =
        search.best(0.5 * best.score,
                    ExcludedPoses{best.target_T_source, options.distinct_m, options.distinct_rad});
    match.iterations += static_cast<int>(second.evaluations);
    if (second.found) {
      result.second_score = second.score;
      result.second_pose = second.target_T_source;
    }
  }

  const ScoreVolume volume =
      score_volume(source, target, window, best.target_T_source, options.evidence);
  match.iterations += static_cast<int>(volume.evaluations);
  const Refined fine = refined(source, target, best.target_T_source, volume.step);
  match.target_T_source = fine.pose;
  match.covariance =
      volume.covariance + covariance_within_step(fine.peak, volume.step, options.evidence);
  match.score = std::max(best.score, 0.0);
  constexpr int kNear = (kSurface + kUnknown) / 2;
  for (const auto& point : source) {
    const Cell cell = target.frame().cell_of(best.target_T_source * point);
    if (target.bound(0, cell.column, cell.row) >= kNear) ++match.pairs;
  }
  match.inlier_fraction = static_cast<double>(match.pairs) / static_cast<double>(source.size());

  const bool ambiguous = result.second_score > options.max_ambiguity * best.score;
  if (ambiguous) {
    // As likely as the best: the spread of two equal peaks.
    const Eigen::Vector3d apart = RigidMotion<2>::difference(*result.second_pose, fine.pose);
    match.covariance += 0.25 * apart * apart.transpose();
  }
  match.status = ambiguous || volume.leaves_window || is_ridge(fine.peak, volume)
                     ? MatchStatus::kDegenerate
                     : MatchStatus::kConverged;
  return result;
}

}  // namespace loopstone
