#pragma once

#include <Eigen/Core>
#include <vector>

namespace loopstone {

/// No coordinate can be farther from the origin [m]: thirty times round the earth, and squares and
/// products of such numbers are still far from the ends of float.
inline constexpr double kFarthestCoordinateM = 1e9;

/// Whether matching may use a point: finite, and no farther away than that.
template <typename Point>
[[nodiscard]] bool is_usable_point(const Eigen::MatrixBase<Point>& point) {
  // Written so that NaN is not usable.
  return (point.array().abs() <= kFarthestCoordinateM).all();
}

/// Points in one frame. Points that are not finite are kept (sensors mark missing returns so); who
/// uses the cloud skips them.
struct PointCloud {
  std::vector<Eigen::Vector3d> points{};  ///< [m]; z is 0 throughout when planar
  bool planar = false;                    ///< the source had x and y alone, or every z was 0
};

}  // namespace loopstone
