#include "loopstone/registration/icp_cloud.hpp"

#include <utility>

#include "loopstone/base/error.hpp"

namespace loopstone {

template <int kDimension>
NearestPoint IcpCloud<kDimension>::nearest_point(const Vector& query, double max_distance_m,
                                                 std::int32_t hint) const {
  if (const auto* cells = std::get_if<CellIndex<kDimension>>(&search)) {
    return cells->nearest_point(query, max_distance_m, hint);
  }
  if constexpr (kDimension == 2) {
    if (const auto* bearings = std::get_if<BearingIndex>(&search)) {
      return bearings->nearest_point(query, max_distance_m, hint);
    }
  }
  return index.nearest_point(query, max_distance_m, hint);
}

template <int kDimension>
IcpCloud<kDimension> make_icp_cloud(std::vector<Eigen::Matrix<double, kDimension, 1>> points,
                                    const IcpCloudOptions<kDimension>& options) {
  PointIndex<kDimension> index(std::move(points));
  auto patches = surface_patches<kDimension>(index, options.patches);
  IcpCloud<kDimension> cloud{std::move(index), std::move(patches), {}};
  switch (options.search) {
    case PointSearch::kKdTree:
      break;
    case PointSearch::kGrid:
      cloud.search = CellIndex<kDimension>(cloud.points(), options.cell_size_m);
      break;
    case PointSearch::kProjection:
      if constexpr (kDimension == 2) {
        cloud.search = BearingIndex(cloud.points());
      } else {
        throw UsageError("search: 'projection' is for scans in the plane; use kd_tree or grid");
      }
      break;
  }
  return cloud;
}

template struct IcpCloud<2>;
template struct IcpCloud<3>;
template IcpCloud<2> make_icp_cloud<2>(std::vector<Eigen::Vector2d>, const IcpCloudOptions<2>&);
template IcpCloud<3> make_icp_cloud<3>(std::vector<Eigen::Vector3d>, const IcpCloudOptions<3>&);

}  // namespace loopstone
