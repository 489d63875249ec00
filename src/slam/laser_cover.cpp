#include "slam/laser_cover.hpp"

#include <cmath>
#include <cstddef>
#include <limits>

#include "loopstone/slam/laser_check.hpp"

namespace loopstone {
namespace {

bool is_near(float range_m) { return range_m > 0.0F && range_m < kLaserCheck.cover_m; }

/// Whether beams passed here, and none ever ended here or beside.
bool is_known_free(const Submap& submap, const Eigen::Vector2d& point) {
  const auto& free = submap.state().free;
  const std::uint8_t* const passed = free.find(free.cell_of(point.x(), point.y()));
  if (passed == nullptr || *passed == 0) return false;
  const auto& surfaces = submap.state().thin_surfaces;
  const Cell middle = surfaces.cell_of(point.x(), point.y());
  for (int row = middle.row - 1; row <= middle.row + 1; ++row) {
    for (int column = middle.column - 1; column <= middle.column + 1; ++column) {
      const SurfaceCell* const cell = surfaces.find({column, row});
      if (cell == nullptr) continue;
      for (const SurfaceSum& sum : cell->sums) {
        if (sum.weight > 0.0F) return false;
      }
    }
  }
  return true;
}

}  // namespace

bool is_covered(const LaserScan& scan, const Pose2& submap_T_lidar, const Submap& submap,
                BeamTable& beams) {
  const auto& directions = beams.directions(scan);
  const Eigen::Matrix2d rotation = submap_T_lidar.rotation();
  std::size_t contradict = 0;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const float range_m = scan.ranges_m[i];
    if (!is_near(range_m)) continue;
    const Eigen::Vector2d point =
        submap_T_lidar.translation() + static_cast<double>(range_m) * (rotation * directions[i]);
    if (is_known_free(submap, point)) ++contradict;
  }
  return static_cast<double>(contradict) >
         kLaserCheck.cover_share * static_cast<double>(directions.size());
}

void take_out_cover(LaserScan& scan) {
  for (float& range_m : scan.ranges_m) {
    if (is_near(range_m)) range_m = std::numeric_limits<float>::quiet_NaN();
  }
}

}  // namespace loopstone
