#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/rigid_motion.hpp"

namespace loopstone::test {

/// Flat pieces of a surface: rectangles in space, segments in the plane (where `v` is nothing).
template <int kDimension>
struct Facet {
  using Vector = Eigen::Matrix<double, kDimension, 1>;
  Vector corner;
  Vector u;
  Vector v;
  Vector normal;  ///< outward, unit

  [[nodiscard]] double size() const {
    if constexpr (kDimension == 2) {
      return u.norm();
    } else {
      return u.cross(v).norm();
    }
  }
};

/// The outline of a polygon, given counter-clockwise.
inline std::vector<Facet<2>> polygon(const std::vector<Eigen::Vector2d>& corners) {
  std::vector<Facet<2>> facets;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d u = corners[(i + 1) % corners.size()] - corners[i];
    facets.push_back(
        {corners[i], u, Eigen::Vector2d::Zero(), Eigen::Vector2d(u.y(), -u.x()).normalized()});
  }
  return facets;
}

/// The faces of a box between two corners.
inline std::vector<Facet<3>> box(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  std::vector<Facet<3>> facets;
  const Eigen::Vector3d size = high - low;
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Vector3d u = Eigen::Vector3d::Zero();
    Eigen::Vector3d v = Eigen::Vector3d::Zero();
    Eigen::Vector3d out = Eigen::Vector3d::Zero();
    u((axis + 1) % 3) = size((axis + 1) % 3);
    v((axis + 2) % 3) = size((axis + 2) % 3);
    out(axis) = 1.0;
    facets.push_back({low, u, v, -out});
    facets.push_back({low + size.cwiseProduct(out), u, v, out});
  }
  return facets;
}

/// A tool with a handle, a battery and a nozzle, 0.2 m long: no turn maps it onto itself.
inline std::vector<Facet<3>> tool() {
  std::vector<Facet<3>> facets;
  for (const auto& part : {box({-0.10, -0.025, 0.0}, {0.06, 0.025, 0.06}),
                           box({0.06, -0.012, 0.02}, {0.11, 0.012, 0.045}),
                           box({-0.07, -0.018, -0.11}, {-0.03, 0.018, 0.0}),
                           box({-0.09, -0.03, -0.15}, {0.01, 0.04, -0.11})}) {
    facets.insert(facets.end(), part.begin(), part.end());
  }
  return facets;
}

/// An outline without symmetry, 4 m long.
inline std::vector<Facet<2>> outline() {
  return polygon({{0.0, 0.0},
                  {4.0, 0.0},
                  {4.0, 1.0},
                  {2.5, 1.0},
                  {2.2, 2.4},
                  {1.2, 2.4},
                  {1.2, 1.4},
                  {0.0, 1.7}});
}

/// Points spread over those facets that face the viewer (all when there is no viewing direction),
/// with noise.
template <int kDimension>
std::vector<Eigen::Matrix<double, kDimension, 1>> sample_surface(
    const std::vector<Facet<kDimension>>& facets, std::size_t count, double noise_m,
    const Eigen::Matrix<double, kDimension, 1>& viewer, Rng& rng) {
  using Vector = Eigen::Matrix<double, kDimension, 1>;
  std::vector<Facet<kDimension>> seen;
  double total = 0.0;
  for (const auto& facet : facets) {
    if (!viewer.isZero() && facet.normal.dot(viewer) < 0.1) continue;
    seen.push_back(facet);
    total += facet.size();
  }
  std::vector<Vector> points;
  while (points.size() < count) {
    double at = rng.uniform(0.0, total);
    std::size_t k = 0;
    while (k + 1 < seen.size() && at >= seen[k].size()) at -= seen[k++].size();
    Vector point = seen[k].corner + rng.uniform() * seen[k].u + rng.uniform() * seen[k].v;
    for (int axis = 0; axis < kDimension; ++axis) point(axis) += rng.normal(0.0, noise_m);
    points.push_back(point);
  }
  return points;
}

template <int kDimension>
Eigen::Matrix<double, kDimension, 1> random_direction(Rng& rng) {
  Eigen::Matrix<double, kDimension, 1> direction;
  for (int axis = 0; axis < kDimension; ++axis) direction(axis) = rng.normal();
  return direction.normalized();
}

/// Any turn, and some metres.
inline Pose2 random_motion(Rng& rng, Pose2) {
  return {rng.normal(), rng.normal(), rng.uniform(-3.14, 3.14)};
}
inline Pose3 random_motion(Rng& rng, Pose3) {
  const Eigen::Vector4d q(rng.normal(), rng.normal(), rng.normal(), rng.normal());
  return {{rng.normal(), rng.normal(), rng.normal()}, Eigen::Quaterniond(q).normalized()};
}

template <typename Pose, typename Vector>
std::vector<Vector> moved(const Pose& a_T_b, std::vector<Vector> points) {
  for (Vector& point : points) point = a_T_b * point;
  return points;
}

}  // namespace loopstone::test
