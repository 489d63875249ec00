#pragma once

#include <Eigen/Core>
#include <vector>

namespace loopstone {

/// Points in one frame. Points that are not finite are kept (sensors mark missing returns so); who uses the cloud skips
/// them.
struct PointCloud {
  std::vector<Eigen::Vector3d> points{};  ///< [m]; z is 0 throughout when planar
  bool planar = false;                    ///< the source had x and y alone, or every z was 0
};

}  // namespace loopstone
