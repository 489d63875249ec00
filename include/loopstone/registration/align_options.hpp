#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "loopstone/grid/grid.hpp"
#include "loopstone/registration/cloud_search.hpp"
#include "loopstone/registration/field_match.hpp"
#include "loopstone/registration/grid_matcher.hpp"
#include "loopstone/registration/icp.hpp"
#include "loopstone/registration/map_match.hpp"
#include "loopstone/registration/scan_matcher.hpp"

namespace loopstone {

/// Options of every matcher that align() may call. The defaults are for scans of buildings.
template <int kDimension>
struct AlignOptions {
  IcpOptions icp{};
  IcpCloudOptions<kDimension> icp_cloud{};
  CloudSearchOptions cloud_search{};
  ScanMatchOptions scans{};
  MapSearchOptions map{};
  MapMatchOptions map_match{};
  FieldMatchOptions field{};
  GridMatchOptions grid{};
};

template <int kDimension, typename Visitor>
void visit_options(AlignOptions<kDimension>& options, Visitor&& visit) {
  visit.group("icp", options.icp);
  visit.group("icp_cloud", options.icp_cloud);
  visit.group("cloud_search", options.cloud_search);
  visit.group("scans", options.scans);
  visit.group("map", options.map);
  visit.group("map_match", options.map_match);
  visit.group("field", options.field);
  visit.group("grid", options.grid);
}

/// What suits a cloud as the target: lengths in proportion to its size. Cost: O(points).
[[nodiscard]] AlignOptions<2> align_options_for(std::span<const Eigen::Vector2d> target);
[[nodiscard]] AlignOptions<3> align_options_for(std::span<const Eigen::Vector3d> target);
/// What suits a map as the target: ICP to its cells.
[[nodiscard]] AlignOptions<2> align_options_for(const Grid<std::int8_t>& map);

}  // namespace loopstone
