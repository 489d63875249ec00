#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "loopstone/base/options.hpp"
#include "loopstone/registration/point_index.hpp"

namespace loopstone {

/// Which neighbours of a point tell the surface around it.
template <int kDimension>
struct PatchOptions {
  int neighbours = kDimension == 2 ? 7 : 12;
  double dense_radius_m = kDimension == 2 ? 0.1 : 0.0;
  double reach_m = 0.6;
  double thickness_share = 0.35;
  bool smooth = kDimension == 2;
};

template <int kDimension, typename Visitor>
void visit_options(PatchOptions<kDimension>& options, Visitor&& visit) {
  visit("neighbours", options.neighbours, Range{3, 64},
        "so many nearest points, itself included, tell the surface around a point");
  visit("dense_radius_m", options.dense_radius_m, Range{0.0, 10.0},
        "and all others up to here, so that noise is averaged where points are dense");
  visit("reach_m", options.reach_m, Range{1e-6, 1e6}, "neighbours farther away are left out");
  visit("thickness_share", options.thickness_share, Range{0.01, 1.0},
        "a neighbourhood thicker than this share of its width is no surface");
  visit("smooth", options.smooth,
        "the surface passes through the mean of the neighbours, which averages noise but cuts "
        "corners; else through the "
        "point");
}

/// The line (in the plane) or plane (in space) fitted to a point and its neighbours.
template <int kDimension>
struct SurfacePatch {
  using Vector = Eigen::Matrix<double, kDimension, 1>;

  /// The patch passes through it: the mean of the neighbourhood, or the point.
  Vector anchor = Vector::Zero();
  Vector normal =
      Vector::Zero();  ///< unit, its side arbitrary; zero when there are too few neighbours to tell
  double radius_m = 0.0;     ///< to the farthest neighbour
  double thickness_m = 0.0;  ///< standard deviation of the neighbours across the patch
  int points = 0;            ///< whose noise the anchor averages
  bool flat = false;         ///< the neighbourhood is a surface
};

/// The patch around every point; for points that are not finite an empty one.
/// Cost: O(points * (neighbours + log points)).
/// Source: Hoppe et al. 1992, "Surface reconstruction from unorganized points", section 3.2.
template <int kDimension>
[[nodiscard]] std::vector<SurfacePatch<kDimension>> surface_patches(
    const PointIndex<kDimension>& index, const PatchOptions<kDimension>& options = {});

extern template std::vector<SurfacePatch<2>> surface_patches<2>(const PointIndex<2>&,
                                                                const PatchOptions<2>&);
extern template std::vector<SurfacePatch<3>> surface_patches<3>(const PointIndex<3>&,
                                                                const PatchOptions<3>&);

}  // namespace loopstone
