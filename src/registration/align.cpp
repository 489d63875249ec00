#include "loopstone/registration/align.hpp"

#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/sensor/point_cloud.hpp"
#include "loopstone/sensor/scan_points.hpp"
#include "registration/align_clouds.hpp"
#include "registration/align_plane.hpp"

namespace loopstone {

namespace {

std::vector<Eigen::Vector2d> points_of(const RobotScan& scan) {
  return scan_points(scan.scan, scan.robot_T_lidar, scan.velocity);
}

std::vector<Eigen::Vector2d> usable(std::span<const Eigen::Vector2d> points) {
  std::vector<Eigen::Vector2d> kept;
  for (const Eigen::Vector2d& point : points) {
    if (is_usable_point(point)) kept.push_back(point);
  }
  return kept;
}

/// The walls as points, where something asks for them.
std::vector<Eigen::Vector2d> walls_for(const AlignRequest<2>& request,
                                       const Grid<std::int8_t>& map) {
  const bool only_grids = request.method == AlignMethod::kAuto ||
                          request.method == AlignMethod::kGrid ||
                          request.method == AlignMethod::kCorrelative;
  if (only_grids && !request.from_centroids) return {};
  return wall_points(map);
}

template <int kDimension>
AlignOptions<kDimension> options_in_proportion(
    std::span<const Eigen::Matrix<double, kDimension, 1>> target) {
  const double radius_m = cloud_extent<kDimension>(target).radius_m;
  AlignOptions<kDimension> options;
  options.icp = icp_options_for_radius(radius_m);
  options.icp_cloud = icp_cloud_options_for_radius<kDimension>(radius_m);
  return options;
}

void check_in_space(const AlignRequest<3>& request) {
  const AlignMethod method = request.method;
  if (method == AlignMethod::kCorrelative || method == AlignMethod::kGrid ||
      method == AlignMethod::kIcpLine) {
    throw UsageError("the method " + std::string(to_string(method)) +
                     " is for the plane; in space there are icp_point, icp_plane, gicp and the "
                     "search from no guess (global)");
  }
  if (request.searches()) {
    throw UsageError(
        "a search window (search-xy, search-yaw) is for the plane; in space search from no guess "
        "(global)");
  }
  if (request.anywhere && request.sweep_yaw > 0) {
    throw UsageError(
        "a sweep of headings (sweep-yaw) tries many starts, and a search from no guess (global) "
        "needs none: leave one of them out");
  }
}

}  // namespace

AlignOptions<2> align_options_for(std::span<const Eigen::Vector2d> target) {
  return options_in_proportion<2>(target);
}

AlignOptions<3> align_options_for(std::span<const Eigen::Vector3d> target) {
  return options_in_proportion<3>(target);
}

AlignOptions<2> align_options_for(const Grid<std::int8_t>& /*map*/) {
  AlignOptions<2> options;
  // Both faces of a thin wall lie a cell or two apart: only the next cells belong to the same one.
  options.icp.max_pair_distance_m = 1.0;
  options.icp_cloud.patches.neighbours = 3;
  options.icp_cloud.patches.dense_radius_m = 0.0;
  options.icp_cloud.patches.smooth = false;
  return options;
}

AlignResult<2> align(const RobotScan& source, const RobotScan& target,
                     const AlignRequest<2>& request) {
  const PlaneSides sides{.source = points_of(source),
                         .source_scan = &source,
                         .target = points_of(target),
                         .target_scan = &target};
  return align_plane(sides, request, request.options.value_or(AlignOptions<2>{}));
}

AlignResult<2> align(const RobotScan& source, const Grid<std::int8_t>& map,
                     const AlignRequest<2>& request) {
  const PlaneSides sides{.source = points_of(source),
                         .source_scan = &source,
                         .target = walls_for(request, map),
                         .map = &map};
  return align_plane(sides, request, request.options.value_or(align_options_for(map)));
}

AlignResult<2> align(std::span<const Eigen::Vector2d> source, const Grid<std::int8_t>& map,
                     const AlignRequest<2>& request) {
  const PlaneSides sides{.source = usable(source), .target = walls_for(request, map), .map = &map};
  return align_plane(sides, request, request.options.value_or(align_options_for(map)));
}

AlignResult<2> align(std::span<const Eigen::Vector2d> source,
                     std::span<const Eigen::Vector2d> target, const AlignRequest<2>& request) {
  const PlaneSides sides{.source = usable(source), .target = usable(target)};
  return align_plane(sides, request,
                     request.options ? *request.options : align_options_for(sides.target));
}

AlignResult<3> align(std::span<const Eigen::Vector3d> source,
                     std::span<const Eigen::Vector3d> target, const AlignRequest<3>& request) {
  check_in_space(request);
  AlignResult<3> result;
  result.source = cloud_extent<3>(source);
  align_clouds<3>(result, source, target, request,
                  request.options ? *request.options : align_options_for(target));
  return result;
}

}  // namespace loopstone
