#include "slam/pose_search.hpp"

#include <algorithm>
#include <cmath>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {

SearchResult search_about_robot(std::span<const Eigen::Vector2d> points, const MaxPyramid& target,
                                const SearchWindow& window, double min_score) {
  const int slices =
      std::max(1, static_cast<int>(std::ceil(window.half_yaw_rad / kPoseSearch.slice_rad)));
  const double half_slice = window.half_yaw_rad / slices;
  SearchResult best;
  best.score = min_score;
  for (int slice = 0; slice < slices; ++slice) {
    SearchWindow part = window;
    part.half_yaw_rad = half_slice;
    part.centre.yaw =
        wrap_angle(window.centre.yaw - window.half_yaw_rad + (2 * slice + 1) * half_slice);
    const SearchResult here = search_branch_and_bound(points, target, part, best.score);
    best.evaluations += here.evaluations;
    if (!here.found || here.score <= best.score) continue;
    best.found = true;
    best.target_T_source = here.target_T_source;
    best.score = here.score;
  }
  return best;
}

std::vector<Eigen::Vector2d> search_points(std::span<const SurfacePoint> surfaces) {
  const std::size_t stride =
      std::max<std::size_t>(1, surfaces.size() / static_cast<std::size_t>(kPoseSearch.points));
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i < surfaces.size(); i += stride)
    points.emplace_back(surfaces[i].position.cast<double>());
  return points;
}

double chi2_from(const PosePrior2& prior, const MatchResult& match) {
  const Eigen::Vector3d off(match.target_T_source.x - prior.target_T_source.x,
                            match.target_T_source.y - prior.target_T_source.y,
                            wrap_angle(match.target_T_source.yaw - prior.target_T_source.yaw));
  return off.dot(prior.information * off);
}

double position_variance_m2(const Eigen::Matrix3d& covariance) {
  const double middle = 0.5 * (covariance(0, 0) + covariance(1, 1));
  const double half = 0.5 * (covariance(0, 0) - covariance(1, 1));
  return middle + hypotenuse(half, covariance(0, 1));
}

double agreement_at(std::span<const Eigen::Vector2d> points, const MaxPyramid& target,
                    const Pose2& target_T_robot) {
  return search_branch_and_bound(points, target, {target_T_robot, 0.0, 0.0}, -1.0).score;
}

}  // namespace loopstone
