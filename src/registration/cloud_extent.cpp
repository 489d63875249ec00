#include "loopstone/registration/cloud_extent.hpp"

#include <algorithm>
#include <cmath>

#include "loopstone/sensor/point_cloud.hpp"

namespace loopstone {

namespace {

constexpr double kRoomRadiusM = 5.0;

}  // namespace

template <int kDimension>
CloudExtent<kDimension> cloud_extent(std::span<const Eigen::Matrix<double, kDimension, 1>> points) {
  CloudExtent<kDimension> extent;
  double count = 0.0;
  for (const auto& point : points) {
    if (!is_usable_point(point)) continue;
    extent.centre += point;
    count += 1.0;
  }
  if (count == 0.0) return extent;
  extent.centre /= count;
  double squares = 0.0;
  for (const auto& point : points) {
    if (is_usable_point(point)) squares += (point - extent.centre).squaredNorm();
  }
  extent.radius_m = std::sqrt(squares / count);
  return extent;
}

IcpOptions icp_options_for_radius(double radius_m) {
  IcpOptions options;
  const double scale = std::max(radius_m, 1e-4) / kRoomRadiusM;
  options.max_pair_distance_m *= scale;
  options.final_pair_distance_m *= scale;
  options.kernel_width_m *= scale;
  options.point_sigma_m *= scale;
  options.tolerance_m *= scale;
  return options;
}

template <int kDimension>
IcpCloudOptions<kDimension> icp_cloud_options_for_radius(double radius_m) {
  IcpCloudOptions<kDimension> options;
  const double scale = std::max(radius_m, 1e-4) / kRoomRadiusM;
  options.cell_size_m *= scale;
  options.patches.dense_radius_m *= scale;
  options.patches.reach_m *= scale;
  return options;
}

template CloudExtent<2> cloud_extent<2>(std::span<const Eigen::Vector2d>);
template CloudExtent<3> cloud_extent<3>(std::span<const Eigen::Vector3d>);
template IcpCloudOptions<2> icp_cloud_options_for_radius<2>(double);
template IcpCloudOptions<3> icp_cloud_options_for_radius<3>(double);

}  // namespace loopstone
