#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <variant>
#include <vector>

#include "loopstone/base/options.hpp"
#include "loopstone/registration/correspondences.hpp"
#include "loopstone/registration/normals.hpp"
#include "loopstone/registration/point_index.hpp"

namespace loopstone {

/// How nearest points are looked up. All find the same ones.
enum class PointSearch {
  kKdTree,
  kGrid,
  kProjection,  ///< by bearing: for single scans in the plane
};

constexpr auto words_of(PointSearch /*any*/) {
  using enum PointSearch;
  return std::array{Word{kKdTree, "kd_tree"}, Word{kGrid, "grid"}, Word{kProjection, "projection"}};
}

template <int kDimension>
struct IcpCloudOptions {
  PointSearch search = PointSearch::kKdTree;
  double cell_size_m = 0.1;
  PatchOptions<kDimension> patches{};
};

template <int kDimension, typename Visitor>
void visit_options(IcpCloudOptions<kDimension>& options, Visitor&& visit) {
  visit("search", options.search,
        "how nearest points are looked up; projection: by bearing, for single scans in the plane");
  visit("cell_size_m", options.cell_size_m, Range{1e-6, 1e6}, "cells of the search by grid");
  visit.group("patches", options.patches);
}

/// A cloud as ICP wants it: points that can be asked for the nearest one, and the surface around
/// each. Made once, then matched with as many clouds as you like, by any number of threads.
template <int kDimension>
struct IcpCloud {
  using Vector = Eigen::Matrix<double, kDimension, 1>;

  PointIndex<kDimension> index;
  std::vector<SurfacePatch<kDimension>> patches;
  /// Another way to look up nearest points than by `index`, when asked for.
  std::variant<std::monostate, CellIndex<kDimension>, BearingIndex> search;

  [[nodiscard]] const std::vector<Vector>& points() const { return index.points(); }
  /// See PointIndex::nearest_point.
  [[nodiscard]] NearestPoint nearest_point(const Vector& query, double max_distance_m,
                                           std::int32_t hint = -1) const;
};

/// \param points  [m]; those that are not finite are ignored
/// Throws UsageError for the search kProjection in space.
/// Cost: O(points log points).
template <int kDimension>
[[nodiscard]] IcpCloud<kDimension> make_icp_cloud(
    std::vector<Eigen::Matrix<double, kDimension, 1>> points,
    const IcpCloudOptions<kDimension>& options = {});

extern template struct IcpCloud<2>;
extern template struct IcpCloud<3>;
extern template IcpCloud<2> make_icp_cloud<2>(std::vector<Eigen::Vector2d>,
                                              const IcpCloudOptions<2>&);
extern template IcpCloud<3> make_icp_cloud<3>(std::vector<Eigen::Vector3d>,
                                              const IcpCloudOptions<3>&);

}  // namespace loopstone
