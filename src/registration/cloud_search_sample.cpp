#include "registration/cloud_search_sample.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

#include "geometry/symmetric_matrix.hpp"

namespace loopstone {

namespace {

template <int kRank, int kDimension>
Eigen::Matrix<double, kRank, kRank> principal_rotation(
    const Eigen::Matrix<double, kDimension, kDimension>& scatter) {
  using Matrix = Eigen::Matrix<double, kRank, kRank>;
  const Matrix part = scatter.template topLeftCorner<kRank, kRank>();
  Matrix rotation = symmetric_eigen(part).vectors.transpose();
  if (rotation.determinant() < 0.0) rotation.row(0) *= -1.0;
  return rotation;
}

/// Some sizes are tried until the number of cells is near enough to what is wanted.
constexpr int kSizesTried = 6;
constexpr double kNearEnough = 1.15;
constexpr std::size_t kMaxCells = std::size_t{1} << 20;

/// The points of each occupied cell: `order` lists the points cell by cell, `begins` where each
/// cell starts, and the end.
struct Cells {
  std::vector<std::size_t> order;
  std::vector<std::size_t> begins;
};

template <int kDimension>
Cells sort_into_cells(std::span<const Eigen::Matrix<float, kDimension, 1>> points,
                      const VoxelFrame<kDimension>& frame) {
  std::vector<std::uint32_t> counts(frame.size(), 0);
  std::vector<std::uint32_t> cell_of(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    cell_of[i] = static_cast<std::uint32_t>(frame.nearest_voxel(points[i]));
    ++counts[cell_of[i]];
  }
  Cells cells;
  std::size_t begin = 0;
  for (std::uint32_t& count : counts) {
    if (count == 0) continue;
    cells.begins.push_back(begin);
    const std::size_t end = begin + count;
    count = static_cast<std::uint32_t>(begin);
    begin = end;
  }
  cells.begins.push_back(begin);
  cells.order.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) cells.order[counts[cell_of[i]]++] = i;
  return cells;
}

}  // namespace

template <int kDimension>
PrincipalFrame<kDimension> principal_frame(
    std::span<const Eigen::Matrix<double, kDimension, 1>> points, bool upright) {
  PrincipalFrame<kDimension> frame;
  for (const auto& point : points) frame.centre += point;
  frame.centre /= static_cast<double>(points.size());
  typename RigidMotion<kDimension>::Matrix scatter = RigidMotion<kDimension>::Matrix::Zero();
  for (const auto& point : points) {
    scatter += (point - frame.centre) * (point - frame.centre).transpose();
  }
  frame.radius_m = std::sqrt(scatter.trace() / static_cast<double>(points.size()));
  if (kDimension == 3 && upright) {
    frame.rotation.template topLeftCorner<2, 2>() = principal_rotation<2>(scatter);
  } else {
    frame.rotation = principal_rotation<kDimension>(scatter);
  }
  return frame;
}

template <int kDimension>
std::vector<Eigen::Matrix<float, kDimension, 1>> in_frame(
    std::span<const Eigen::Matrix<double, kDimension, 1>> points,
    const PrincipalFrame<kDimension>& frame) {
  std::vector<Eigen::Matrix<float, kDimension, 1>> result;
  result.reserve(points.size());
  for (const auto& point : points) {
    result.push_back((frame.rotation * (point - frame.centre)).template cast<float>());
  }
  return result;
}

template <int kDimension>
std::vector<std::size_t> spread_sample(std::span<const Eigen::Matrix<float, kDimension, 1>> points,
                                       std::size_t count) {
  using Point = Eigen::Matrix<float, kDimension, 1>;
  std::vector<std::size_t> sample(points.size());
  std::iota(sample.begin(), sample.end(), std::size_t{0});
  if (points.size() <= count) return sample;

  float extent = 0.0F;
  for (const Point& point : points) extent = std::max(extent, point.norm());
  if (!(extent > 0.0F)) return {0};
  // Points lie on a surface (a curve, in the plane): their number goes with the size of cells to
  // the power 1 - D.
  double size_m = 2.0 * extent / std::pow(static_cast<double>(count), 1.0 / (kDimension - 1));
  Cells cells;
  for (int tried = 0; tried < kSizesTried; ++tried) {
    cells = sort_into_cells<kDimension>(
        points, voxels_covering<kDimension>(points, static_cast<float>(size_m), 0.0F, kMaxCells));
    const double ratio = static_cast<double>(cells.begins.size() - 1) / static_cast<double>(count);
    if (ratio < kNearEnough && ratio > 1.0 / kNearEnough) break;
    size_m *= std::pow(ratio, 1.0 / (kDimension - 1));
  }
  sample.clear();
  for (std::size_t cell = 0; cell + 1 < cells.begins.size(); ++cell) {
    const std::span<const std::size_t> members(cells.order.data() + cells.begins[cell],
                                               cells.begins[cell + 1] - cells.begins[cell]);
    Point mean = Point::Zero();
    for (const std::size_t i : members) mean += points[i];
    mean /= static_cast<float>(members.size());
    sample.push_back(*std::min_element(members.begin(), members.end(), [&](auto a, auto b) {
      return (points[a] - mean).squaredNorm() < (points[b] - mean).squaredNorm();
    }));
  }
  return sample;
}

template PrincipalFrame<2> principal_frame<2>(std::span<const Eigen::Vector2d>, bool);
template PrincipalFrame<3> principal_frame<3>(std::span<const Eigen::Vector3d>, bool);
template std::vector<Eigen::Vector2f> in_frame<2>(std::span<const Eigen::Vector2d>,
                                                  const PrincipalFrame<2>&);
template std::vector<Eigen::Vector3f> in_frame<3>(std::span<const Eigen::Vector3d>,
                                                  const PrincipalFrame<3>&);
template std::vector<std::size_t> spread_sample<2>(std::span<const Eigen::Vector2f>, std::size_t);
template std::vector<std::size_t> spread_sample<3>(std::span<const Eigen::Vector3f>, std::size_t);

}  // namespace loopstone
