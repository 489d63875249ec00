#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "loopstone/formats/point_cloud_file.hpp"
#include "loopstone/registration/cloud_extent.hpp"
#include "loopstone/registration/cloud_search.hpp"
#include "loopstone/registration/icp.hpp"
#include "refusal.hpp"

// What every target does with a cloud that could be read.
namespace loopstone::fuzz {

/// Few enough to be matched in milliseconds.
inline constexpr std::size_t kMostPoints = 200;

/// Two walls of a room and, in space, a slope.
template <int kDimension>
std::vector<Eigen::Matrix<double, kDimension, 1>> corner() {
  std::vector<Eigen::Matrix<double, kDimension, 1>> points;
  for (int i = 0; i < 20; ++i) {
    for (int k = 0; k < (kDimension == 2 ? 1 : 3); ++k) {
      Eigen::Matrix<double, kDimension, 1> along;
      Eigen::Matrix<double, kDimension, 1> aside;
      along.setConstant(0.2 * k * i);
      aside.setConstant(0.1 * k);
      along.template head<2>() << 0.1 * i, 0.0;
      aside.template head<2>() << 0.0, 0.05 * i;
      points.push_back(along);
      points.push_back(aside);
    }
  }
  return points;
}

template <int kDimension>
void match_both_ways(const std::vector<Eigen::Matrix<double, kDimension, 1>>& points) {
  using Point = Eigen::Matrix<double, kDimension, 1>;
  const std::vector<Point> known = corner<kDimension>();
  const auto match = [](const std::vector<Point>& source, const std::vector<Point>& target) {
    const std::span<const Point> all(target);
    const double radius_m = cloud_extent<kDimension>(all).radius_m;
    IcpOptions icp = icp_options_for_radius(radius_m);
    icp.max_iterations = 10;
    const auto cloud =
        make_icp_cloud<kDimension>(target, icp_cloud_options_for_radius<kDimension>(radius_m));
    (void)match_icp(std::span(source), cloud, {}, icp);
    CloudSearchOptions search;
    search.starts = 8;
    search.max_iterations = 10;
    (void)search_alignment<kDimension>(std::span<const Point>(source), CloudModel<kDimension>{all},
                                       search);
  };
  match(points, known);
  match(known, points);
}

/// Writes it, reads that again and matches it, as source and as target.
inline void use_cloud(const PointCloud& cloud) {
  if (decode_ply(encode_ply(cloud)).points.size() != cloud.points.size()) __builtin_trap();
  (void)encode_pcd(cloud);
  if (!goes_on()) return;
  std::vector<Eigen::Vector2d> flat;
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3d& point : cloud.points) {
    if (points.size() == kMostPoints) break;
    if (!point.allFinite()) continue;
    points.push_back(point);
    flat.emplace_back(point.head<2>());
  }
  if (cloud.planar) {
    match_both_ways<2>(flat);
  } else {
    match_both_ways<3>(points);
  }
}

}  // namespace loopstone::fuzz
