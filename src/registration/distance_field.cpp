#include "loopstone/registration/distance_field.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <limits>

#include "geometry/symmetric_matrix.hpp"

namespace loopstone {

namespace {

/// Stands for "no site yet": larger than any squared distance in voxels.
constexpr double kFar = 1e30;

/// The voxel along an axis that is nearest to a place; the first one for NaN.
std::int32_t clamped_voxel(float along, float last) {
  return static_cast<std::int32_t>(along > 0.0F ? std::min(along, last) : 0.0F);
}

/// One line of voxels: squared distances (in voxels) to sites, and the sites' numbers.
struct Line {
  std::vector<double> squared;
  std::vector<std::int32_t> site;
};

/// The lower envelope of the parabolas squared[q] + (x - q)^2 along a line. All numbers are whole,
/// but for where two parabolas meet.
class LowerEnvelope {
 public:
  /// Replaces the line by the envelope's values and the sites that they come from.
  void apply(Line& line) {
    const std::size_t count = line.squared.size();
    vertices_.resize(count);
    std::size_t size = 0;
    for (std::size_t q = 0; q < count; ++q) {
      if (line.squared[q] >= kFar) continue;
      const auto at = static_cast<double>(q);
      Vertex next{at, line.squared[q], line.squared[q] + at * at, 0.0, line.site[q]};
      for (; size > 0; --size) {
        const Vertex& before = vertices_[size - 1];
        next.begin = 0.5 * (next.raised - before.raised) / (next.at - before.at);
        if (next.begin > before.begin) break;
      }
      if (size == 0) next.begin = -kFar;
      vertices_[size++] = next;
    }
    if (size == 0) return;
    std::size_t k = 0;
    for (std::size_t x = 0; x < count; ++x) {
      const auto at = static_cast<double>(x);
      while (k + 1 < size && vertices_[k + 1].begin <= at) ++k;
      const double offset = at - vertices_[k].at;
      line.squared[x] = offset * offset + vertices_[k].height;
      line.site[x] = vertices_[k].site;
    }
  }

 private:
  struct Vertex {
    double at;
    double height;
    double raised;  ///< height + at^2
    double begin;   ///< from here on this parabola is the lowest
    std::int32_t site;
  };
  std::vector<Vertex> vertices_{};
};

}  // namespace

template <int kDimension>
VoxelFrame<kDimension> voxels_covering(std::span<const Eigen::Matrix<float, kDimension, 1>> points,
                                       float resolution_m, float margin_m, std::size_t max_voxels) {
  using Point = Eigen::Matrix<float, kDimension, 1>;
  assert(!points.empty() &&
         resolution_m >= 0.0F);  // a radius of 1e-50 m is none in single precision
  Point low = points.front();
  Point high = points.front();
  for (const Point& point : points) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  // Finer voxels than this can't be told apart, or counted, in single precision; none can be of no
  // size.
  const float farthest = low.cwiseAbs().cwiseMax(high.cwiseAbs()).maxCoeff() + margin_m;
  VoxelFrame<kDimension> frame;
  for (frame.resolution_m = std::max({resolution_m, farthest * 1e-6F, 1e-15F});;
       frame.resolution_m *= 1.25F) {
    double voxels = 1.0;
    for (int axis = 0; axis < kDimension; ++axis) {
      const float first = std::floor((low(axis) - margin_m) / frame.resolution_m);
      const float count = std::floor((high(axis) + margin_m) / frame.resolution_m) - first + 1.0F;
      frame.low(axis) = first * frame.resolution_m;
      frame.counts[static_cast<std::size_t>(axis)] =
          static_cast<std::int32_t>(std::min(count, 1e9F));
      voxels *= static_cast<double>(count);
    }
    if (voxels <= static_cast<double>(max_voxels)) return frame;
  }
}

template <int kDimension>
DistanceField<kDimension>::DistanceField(std::span<const Point> points,
                                         const VoxelFrame<kDimension>& frame)
    : frame_(frame) {
  assert(!points.empty());
  // Points sorted by voxel.
  begins_.assign(frame.size() + 1, 0);
  std::vector<std::uint32_t> voxels(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    voxels[i] = static_cast<std::uint32_t>(frame.nearest_voxel(points[i]));
    ++begins_[voxels[i] + 1];
  }
  for (std::size_t v = 1; v < begins_.size(); ++v) begins_[v] += begins_[v - 1];
  points_.resize(points.size());
  std::vector<std::int32_t> next(begins_.begin(), begins_.end() - 1);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points_[static_cast<std::size_t>(next[voxels[i]]++)] = points[i];
  }
  // The mean of each voxel's points.
  nearest_.assign(frame.size(), -1);
  for (std::size_t v = 0; v < nearest_.size(); ++v) {
    if (begins_[v] == begins_[v + 1]) continue;
    nearest_[v] = static_cast<std::int32_t>(sites_.size());
    Point sum = Point::Zero();
    for (std::int32_t i = begins_[v]; i < begins_[v + 1]; ++i) {
      sum += points_[static_cast<std::size_t>(i)];
    }
    sites_.push_back(sum / static_cast<float>(begins_[v + 1] - begins_[v]));
    first_of_site_.push_back(begins_[v]);
  }
  // Nearest sites along the first axis, then in planes, then in space.
  std::vector<double> squared(nearest_.size());
  for (std::size_t v = 0; v < squared.size(); ++v) squared[v] = nearest_[v] >= 0 ? 0.0 : kFar;
  LowerEnvelope envelope;
  Line line;
  std::size_t stride = 1;
  for (const std::int32_t count : frame.counts) {
    const auto length = static_cast<std::size_t>(count);
    line.squared.resize(length);
    line.site.resize(length);
    for (std::size_t block = 0; block < nearest_.size(); block += stride * length) {
      for (std::size_t first = block; first < block + stride; ++first) {
        for (std::size_t k = 0; k < length; ++k) {
          line.squared[k] = squared[first + k * stride];
          line.site[k] = nearest_[first + k * stride];
        }
        envelope.apply(line);
        for (std::size_t k = 0; k < length; ++k) {
          squared[first + k * stride] = line.squared[k];
          nearest_[first + k * stride] = line.site[k];
        }
      }
    }
    stride *= length;
  }
}

namespace {

/// The first and the last voxel along each axis that a ball touches.
template <int kDimension>
struct VoxelBox {
  std::array<std::int32_t, kDimension> first{};
  std::array<std::int32_t, kDimension> last{};
};

template <int kDimension>
VoxelBox<kDimension> voxels_around(const VoxelFrame<kDimension>& frame,
                                   const Eigen::Matrix<float, kDimension, 1>& centre,
                                   float radius_m) {
  VoxelBox<kDimension> box;
  const float per_m = 1.0F / frame.resolution_m;
  for (std::size_t a = 0; a < box.first.size(); ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    const auto end = static_cast<float>(frame.counts[a] - 1);
    // A little wider than the ball: rounding must not lose a voxel.
    const float from = (centre(axis) - radius_m - frame.low(axis)) * per_m - 1e-3F;
    const float to = (centre(axis) + radius_m - frame.low(axis)) * per_m + 1e-3F;
    box.first[a] = clamped_voxel(from, end);
    box.last[a] = clamped_voxel(to, end);
  }
  return box;
}

}  // namespace

template <int kDimension>
typename DistanceField<kDimension>::Nearest DistanceField<kDimension>::nearest_point(
    const Point& query, std::int32_t hint) const {
  Nearest best{hint, 0.0F};
  if (hint < 0) {
    best.point = first_of_site_[static_cast<std::size_t>(nearest_[frame_.nearest_voxel(query)])];
  }
  best.squared_distance_m2 = (points_[static_cast<std::size_t>(best.point)] - query).squaredNorm();

  // Rows of voxels, along the first axis, that the ball of that radius touches.
  const VoxelBox<kDimension> box =
      voxels_around<kDimension>(frame_, query, std::sqrt(best.squared_distance_m2));
  const auto& first = box.first;
  const auto& last = box.last;
  const auto scan_row = [&](std::size_t row, float squared_to_row) {
    if (squared_to_row > best.squared_distance_m2) return;
    const std::int32_t begin = begins_[row + static_cast<std::size_t>(first[0])];
    const std::int32_t end = begins_[row + static_cast<std::size_t>(last[0]) + 1];
    for (std::int32_t i = begin; i < end; ++i) {
      const float squared = (points_[static_cast<std::size_t>(i)] - query).squaredNorm();
      if (squared < best.squared_distance_m2 ||
          (squared == best.squared_distance_m2 && i < best.point)) {
        best = {i, squared};
      }
    }
  };
  const auto squared_to_slab = [&](std::size_t a, std::int32_t voxel) {
    const auto axis = static_cast<Eigen::Index>(a);
    const float low = frame_.low(axis) + static_cast<float>(voxel) * frame_.resolution_m;
    // A little less than it is: see above.
    const float slack = 1e-3F * frame_.resolution_m;
    const float outside = std::max(
        {0.0F, low - query(axis) - slack, query(axis) - low - frame_.resolution_m - slack});
    return outside * outside;
  };
  const auto columns = static_cast<std::size_t>(frame_.counts[0]);
  if constexpr (kDimension == 2) {
    for (std::int32_t y = first[1]; y <= last[1]; ++y) {
      scan_row(static_cast<std::size_t>(y) * columns, squared_to_slab(1, y));
    }
  } else {
    const auto rows = static_cast<std::size_t>(frame_.counts[1]);
    for (std::int32_t z = first[2]; z <= last[2]; ++z) {
      const float squared_z = squared_to_slab(2, z);
      if (squared_z > best.squared_distance_m2) continue;
      for (std::int32_t y = first[1]; y <= last[1]; ++y) {
        scan_row((static_cast<std::size_t>(z) * rows + static_cast<std::size_t>(y)) * columns,
                 squared_z + squared_to_slab(1, y));
      }
    }
  }
  return best;
}

template <int kDimension>
typename DistanceField<kDimension>::Point DistanceField<kDimension>::normal_near(
    const Point& place) const {
  using Vector = Eigen::Matrix<double, kDimension, 1>;
  using Matrix = Eigen::Matrix<double, kDimension, kDimension>;
  constexpr int kReach = 1;
  constexpr int kBlock = kDimension == 2 ? 9 : 27;
  double count = 0.0;
  Vector sum = Vector::Zero();
  Matrix squares = Matrix::Zero();
  for (int k = 0; k < kBlock; ++k) {
    Point at = place;
    for (int axis = 0, rest = k; axis < kDimension; ++axis, rest /= 3) {
      at(axis) += static_cast<float>(rest % 3 - kReach) * frame_.resolution_m;
    }
    if (!frame_.contains(at)) continue;
    const std::size_t voxel = frame_.nearest_voxel(at);
    for (std::int32_t i = begins_[voxel]; i < begins_[voxel + 1]; ++i) {
      const Vector arm = (points_[static_cast<std::size_t>(i)] - place).template cast<double>();
      count += 1.0;
      sum += arm;
      squares += arm * arm.transpose();
    }
  }
  if (count > 0.0) squares -= sum * sum.transpose() / count;
  return symmetric_eigen(squares).vectors.col(0).template cast<float>();
}

template VoxelFrame<2> voxels_covering<2>(std::span<const Eigen::Vector2f>, float, float,
                                          std::size_t);
template VoxelFrame<3> voxels_covering<3>(std::span<const Eigen::Vector3f>, float, float,
                                          std::size_t);
template class DistanceField<2>;
template class DistanceField<3>;

}  // namespace loopstone
