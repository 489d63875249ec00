#pragma once

#include <Eigen/Core>
#include <span>

#include "loopstone/registration/icp.hpp"

namespace loopstone {

/// Where a cloud is and how large.
template <int kDimension>
struct CloudExtent {
  Eigen::Matrix<double, kDimension, 1> centre =
      Eigen::Matrix<double, kDimension, 1>::Zero();  ///< the centroid [m]
  double radius_m = 0.0;                             ///< root mean square distance from it
};

/// Of the points that are finite. Cost: O(points).
template <int kDimension>
[[nodiscard]] CloudExtent<kDimension> cloud_extent(
    std::span<const Eigen::Matrix<double, kDimension, 1>> points);

/// Options for clouds of any size: the defaults of IcpOptions are made for rooms, whose radius is
/// about 5 m; here every length keeps its ratio to the radius.
[[nodiscard]] IcpOptions icp_options_for_radius(double radius_m);
/// The same for the search of neighbours.
template <int kDimension>
[[nodiscard]] IcpCloudOptions<kDimension> icp_cloud_options_for_radius(double radius_m);

extern template CloudExtent<2> cloud_extent<2>(std::span<const Eigen::Vector2d>);
extern template CloudExtent<3> cloud_extent<3>(std::span<const Eigen::Vector3d>);
extern template IcpCloudOptions<2> icp_cloud_options_for_radius<2>(double);
extern template IcpCloudOptions<3> icp_cloud_options_for_radius<3>(double);

}  // namespace loopstone
