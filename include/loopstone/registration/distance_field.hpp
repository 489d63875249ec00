#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace loopstone {

/// Where a dense block of square (cubic) cells lies, in the plane or in space. Corners of cells are
/// whole multiples of the resolution, so mirroring the axes mirrors the cells.
template <int kDimension>
struct VoxelFrame {
  using Point = Eigen::Matrix<float, kDimension, 1>;
  using Counts = std::array<std::int32_t, kDimension>;

  Point low = Point::Zero();  ///< lowest corner of the first voxel [m]
  float resolution_m = 1.0F;
  Counts counts{};  ///< voxels along each axis

  [[nodiscard]] std::size_t size() const {
    std::size_t product = 1;
    for (const std::int32_t count : counts) product *= static_cast<std::size_t>(count);
    return product;
  }
  [[nodiscard]] bool contains(const Point& point) const {
    for (int axis = 0; axis < kDimension; ++axis) {
      const float along = (point(axis) - low(axis)) / resolution_m;
      const auto count = static_cast<float>(counts[static_cast<std::size_t>(axis)]);
      if (!(along >= 0.0F && along < count)) return false;
    }
    return true;
  }
  /// Of the voxel that holds the point, or of the voxel of the block that is nearest to it. The
  /// first axis runs fastest.
  [[nodiscard]] std::size_t nearest_voxel(const Point& point) const {
    std::size_t index = 0;
    for (int axis = kDimension - 1; axis >= 0; --axis) {
      const auto last = static_cast<float>(counts[static_cast<std::size_t>(axis)] - 1);
      const float along = (point(axis) - low(axis)) / resolution_m;
      const float clamped = along > 0.0F ? (along < last ? along : last) : 0.0F;
      index = index * static_cast<std::size_t>(counts[static_cast<std::size_t>(axis)]) +
              static_cast<std::size_t>(clamped);
    }
    return index;
  }
};

/// The smallest block of voxels that covers the points and so many metres around them. The
/// resolution is coarsened until there are no more than max_voxels.
/// \param points  finite, at least one
template <int kDimension>
[[nodiscard]] VoxelFrame<kDimension> voxels_covering(
    std::span<const Eigen::Matrix<float, kDimension, 1>> points, float resolution_m, float margin_m,
    std::size_t max_voxels);

/// For every voxel around a cloud the nearest voxel that holds points, and the mean of those: what
/// is near a place is known from one look-up, to about the size of a voxel. From there the nearest
/// point is found exactly, in the few voxels that can hold it.
template <int kDimension>
class DistanceField {
 public:
  using Point = Eigen::Matrix<float, kDimension, 1>;

  struct Nearest {
    std::int32_t point = 0;  ///< its place in points()
    float squared_distance_m2 = 0.0F;
  };

  /// \param points  finite, at least one, all within the frame
  /// Distances between voxels' centres are exact; of equally near voxels any, but always the same.
  /// Cost: O(voxels + points).
  /// Source: Felzenszwalb and Huttenlocher 2012, "Distance transforms of sampled functions",
  /// section 2.1, carried to D dimensions, with the number of the nearest site kept beside its
  /// distance.
  DistanceField(std::span<const Point> points, const VoxelFrame<kDimension>& frame);

  [[nodiscard]] const VoxelFrame<kDimension>& frame() const { return frame_; }
  /// The points, voxel by voxel.
  [[nodiscard]] const std::vector<Point>& points() const { return points_; }
  /// The means of the points of one voxel each, in the order of the voxels.
  [[nodiscard]] const std::vector<Point>& sites() const { return sites_; }
  /// For each voxel the number of the nearest site.
  [[nodiscard]] const std::vector<std::int32_t>& nearest() const { return nearest_; }

  [[nodiscard]] const Point& nearest_site(const Point& query) const {
    return sites_[static_cast<std::size_t>(nearest_[frame_.nearest_voxel(query)])];
  }
  /// The nearest of the points, exactly.
  /// \param hint  the place of a point that may be near; it makes the search shorter. -1: none
  /// Cost: about the points within reach, and the rows of voxels within reach.
  [[nodiscard]] Nearest nearest_point(const Point& query, std::int32_t hint = -1) const;
  /// Across which the points of the voxels around a place are thinnest: unit, its side arbitrary.
  [[nodiscard]] Point normal_near(const Point& place) const;

 private:
  VoxelFrame<kDimension> frame_;
  std::vector<Point> points_{};
  std::vector<std::int32_t> begins_{};  ///< of each voxel's points, and the end of the last one's
  std::vector<std::int32_t> first_of_site_{};
  std::vector<Point> sites_{};
  std::vector<std::int32_t> nearest_{};
};

extern template VoxelFrame<2> voxels_covering<2>(std::span<const Eigen::Vector2f>, float, float,
                                                 std::size_t);
extern template VoxelFrame<3> voxels_covering<3>(std::span<const Eigen::Vector3f>, float, float,
                                                 std::size_t);
extern template class DistanceField<2>;
extern template class DistanceField<3>;

}  // namespace loopstone
