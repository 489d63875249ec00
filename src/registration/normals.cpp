#include "loopstone/registration/normals.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "registration/kd_tree.hpp"

namespace loopstone {

namespace {

constexpr std::size_t kMostNeighbours = 64;

/// Sums over a neighbourhood, relative to its point.
template <int kDimension>
struct Moments {
  using Vector = Eigen::Matrix<double, kDimension, 1>;
  using Matrix = Eigen::Matrix<double, kDimension, kDimension>;

  Vector sum = Vector::Zero();
  Matrix squares = Matrix::Zero();
  int count = 0;
  double greatest_squared_distance = 0.0;

  void add(const Vector& arm, double squared_distance) {
    sum += arm;
    squares += arm * arm.transpose();
    greatest_squared_distance = std::max(greatest_squared_distance, squared_distance);
    ++count;
  }
};

/// Eigenvalues, least first, and the direction of the least.
template <int kDimension>
struct Shape {
  Eigen::Matrix<double, kDimension, 1> eigenvalues;
  Eigen::Matrix<double, kDimension, 1> normal;
};

Shape<2> shape_of(const Eigen::Matrix2d& scatter) {
  // Eigenvalues of a symmetric 2x2 matrix: middle +- spread; the line runs at half the angle of
  // (difference, 2 xy).
  const double middle = 0.5 * (scatter(0, 0) + scatter(1, 1));
  const double difference = 0.5 * (scatter(0, 0) - scatter(1, 1));
  const double spread = std::sqrt(difference * difference + scatter(0, 1) * scatter(0, 1));
  // cos and sin of half the angle without leaving the algebraic functions.
  Eigen::Vector2d along(1.0, 0.0);
  if (spread > 0.0) {
    along = difference >= 0.0 ? Eigen::Vector2d(spread + difference, scatter(0, 1))
                              : Eigen::Vector2d(scatter(0, 1), spread - difference);
    along.normalize();
  }
  return {{std::max(middle - spread, 0.0), middle + spread}, {-along.y(), along.x()}};
}

Shape<3> shape_of(const Eigen::Matrix3d& scatter) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
  eigen.computeDirect(scatter);
  return {eigen.eigenvalues().cwiseMax(0.0), eigen.eigenvectors().col(0)};
}

template <int kDimension>
SurfacePatch<kDimension> fitted(const Eigen::Matrix<double, kDimension, 1>& point,
                                const Moments<kDimension>& moments,
                                const PatchOptions<kDimension>& options) {
  SurfacePatch<kDimension> patch;
  patch.points = 1;
  patch.anchor = point;
  patch.radius_m = std::sqrt(moments.greatest_squared_distance);
  if (moments.count <= kDimension) return patch;
  const double count = moments.count;
  if (options.smooth) {
    patch.anchor += moments.sum / count;
    patch.points = moments.count;
  }
  const Eigen::Matrix<double, kDimension, kDimension> scatter =
      moments.squares - moments.sum * moments.sum.transpose() / count;
  const Shape<kDimension> shape = shape_of(scatter);
  // A patch has as many parameters across it as there are dimensions.
  patch.thickness_m = std::sqrt(shape.eigenvalues(0) / (count - kDimension));
  if (!(shape.eigenvalues(1) > 0.0)) return patch;
  patch.normal = shape.normal;
  const double share = options.thickness_share;
  patch.flat = shape.eigenvalues(0) <= share * share * shape.eigenvalues(1);
  return patch;
}

}  // namespace

template <int kDimension>
std::vector<SurfacePatch<kDimension>> surface_patches(const PointIndex<kDimension>& index,
                                                      const PatchOptions<kDimension>& options) {
  using Vector = Eigen::Matrix<double, kDimension, 1>;
  using Tree = KdTree<kDimension>;
  const Tree& tree = index.tree();
  std::vector<SurfacePatch<kDimension>> patches(index.points().size());
  const auto count = std::min(static_cast<std::size_t>(options.neighbours), kMostNeighbours);
  const double squared_reach = options.reach_m * options.reach_m;
  std::array<typename Tree::Found, kMostNeighbours> found;
  std::int32_t before = -1;
  tree.for_each([&](const Vector& point, std::int32_t number) {
    // Points at one place have one patch; a cloud of nothing else would take the square of their
    // number.
    if (before >= 0 && index.points()[static_cast<std::size_t>(before)] == point) {
      patches[static_cast<std::size_t>(number)] = patches[static_cast<std::size_t>(before)];
      return;
    }
    before = number;
    Moments<kDimension> moments;
    if (options.dense_radius_m > 0.0) {
      tree.for_each_within(point, std::min(options.dense_radius_m, options.reach_m),
                           [&](const Vector& neighbour, std::int32_t, double squared) {
                             moments.add(neighbour - point, squared);
                           });
    }
    if (moments.count < static_cast<int>(count)) {
      moments = {};
      const std::size_t size = tree.nearest_several(point, count, found.data());
      for (std::size_t i = 0; i < size && found[i].squared_distance_m2 <= squared_reach; ++i) {
        moments.add(index.points()[static_cast<std::size_t>(found[i].index)] - point,
                    found[i].squared_distance_m2);
      }
    }
    patches[static_cast<std::size_t>(number)] = fitted<kDimension>(point, moments, options);
  });
  return patches;
}

template std::vector<SurfacePatch<2>> surface_patches<2>(const PointIndex<2>&,
                                                         const PatchOptions<2>&);
template std::vector<SurfacePatch<3>> surface_patches<3>(const PointIndex<3>&,
                                                         const PatchOptions<3>&);

}  // namespace loopstone
