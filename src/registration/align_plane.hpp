#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "loopstone/registration/align.hpp"

namespace loopstone {

/// Both sides of an alignment in the plane, as the matchers want them.
struct PlaneSides {
  std::vector<Eigen::Vector2d> source{};   ///< the source's frame
  const RobotScan* source_scan = nullptr;  ///< where the points are from
  std::vector<Eigen::Vector2d> target{};   ///< the target's frame; a map's walls
  const RobotScan* target_scan = nullptr;  ///< where they are from
  const Grid<std::int8_t>* map = nullptr;  ///< or these

  [[nodiscard]] bool both_scans() const { return source_scan != nullptr && target_scan != nullptr; }
};

/// Picks the matcher that suits the sides and the request, and runs it.
[[nodiscard]] AlignResult<2> align_plane(const PlaneSides& sides, const AlignRequest<2>& request,
                                         const AlignOptions<2>& options);

}  // namespace loopstone
