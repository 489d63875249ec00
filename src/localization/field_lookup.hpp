#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"

// The inner loops of the likelihood field, compiled once for each instruction set
// (field_lookup.cpp). Every float and double operation is one that IEEE 754 rounds in only one way
// (no fused multiply-add), in the same order everywhere.
namespace loopstone::detail {

/// Bytes of a map and how to find the one below a point. Coordinates are in cells, with a border of
/// one cell: cell (1, 1) is the map's lower left one.
struct ByteField {
  const std::uint8_t* cells = nullptr;
  std::uint32_t padded_rows = 0;  ///< a strip has 8 * padded_rows cells
  float last_column = 0.0F;       ///< the border on the far sides; at most 2^22
  float last_row = 0.0F;
  double origin_x_m = 0.0;
  double origin_y_m = 0.0;
  double cells_per_m = 0.0;  ///< in [1e-3, 1e5]
};

/// Lengths of the arrays below are whole multiples of this; no vector that is used holds more
/// floats.
inline constexpr std::size_t kLaneMultiple = 16;
/// Look-ups whose places are computed before the first is made.
inline constexpr std::size_t kAtOnce = 512;
/// Positions of poses farther away are outside the map [cells], and so are points [m]. Numbers that
/// are not finite count as far away, so that the inner loops never meet a NaN.
inline constexpr double kMostCoordinate = 1e7;
inline constexpr float kFarthestPoint_m = 1e6F;
inline constexpr float kFarPoint_m =
    1e12F;  ///< outside from every pose that is nearer than kMostCoordinate

/// Structures of arrays; all entries up to the padded length lie outside the map.
struct PointArrays {
  std::vector<float> x;  ///< [m]
  std::vector<float> y;
};
struct PoseArrays {
  std::vector<float> cos;  ///< [cells/m]
  std::vector<float> sin;
  std::vector<float> x;  ///< [cells], half a cell less than the coordinate, which is rounded
  std::vector<float> y;
};

/// `count` rounded up to a whole multiple of kLaneMultiple.
[[nodiscard]] inline std::size_t padded(std::size_t count) {
  return (count + kLaneMultiple - 1) / kLaneMultiple * kLaneMultiple;
}

[[nodiscard]] PointArrays point_arrays(std::span<const Eigen::Vector2f> points);
/// Room for so many poses.
[[nodiscard]] PoseArrays pose_arrays(std::size_t count);

/// Fills in the poses of [begin, end), begin a multiple of kLaneMultiple: sines and cosines with an
/// error below 1e-7, positions in cells.
void prepare_poses(const ByteField& field, std::span<const Pose2> map_T_robot, std::size_t begin,
                   std::size_t end, PoseArrays& poses);

/// For each pose of `order`: the sum of the field's bytes below all points, padding included.
void sum_over_points(const ByteField& field, const PoseArrays& poses,
                     std::span<const std::uint32_t> order, const PointArrays& points,
                     std::uint64_t* sums);

/// For each point in [begin, end): the sum of the bytes below it from all poses, padding included.
void sum_over_poses(const ByteField& field, const PoseArrays& poses, const PointArrays& points,
                    std::size_t begin, std::size_t end, std::uint64_t* sums);

}  // namespace loopstone::detail
