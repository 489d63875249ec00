#pragma once

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/polygon.hpp"
#include "loopstone/plan/extract_plan.hpp"

namespace loopstone::test {

/// Floor with walls around it, as a perfect mapper would have it.
class PlanScene {
 public:
  /// \param noise_m  of each sample
  explicit PlanScene(const Pose2& map_T_scene = {}, double noise_m = 0.01)
      : map_T_scene_(map_T_scene), noise_m_(noise_m) {}

  /// A piece of floor, counter-clockwise. Its sides are walls where `is_wall` says so.
  PlanScene& floor(std::vector<Eigen::Vector2d> corners, std::vector<bool> is_wall = {}) {
    const std::size_t count = corners.size();
    for (std::size_t i = 0; i < count; ++i) {
      if (is_wall.empty() || is_wall[i]) face(corners[i], corners[(i + 1) % count]);
    }
    floors_.push_back(map_T_scene_ * Polygon2{std::move(corners)});
    return *this;
  }
  PlanScene& rectangle(double width, double depth) {
    return floor({{0.0, 0.0}, {width, 0.0}, {width, depth}, {0.0, depth}});
  }
  /// A surface with free space on its left.
  PlanScene& face(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    faces_.emplace_back(map_T_scene_ * from, map_T_scene_ * to);
    return *this;
  }

  [[nodiscard]] Grid<std::int8_t> cells() const {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    Eigen::Vector2d low(kFar, kFar);
    Eigen::Vector2d high(-kFar, -kFar);
    for (const Polygon2& floor : floors_) {
      for (const Eigen::Vector2d& corner : floor.corners) {
        low = low.cwiseMin(corner);
        high = high.cwiseMax(corner);
      }
    }
    Grid<std::int8_t> cells(frame_covering(low, high, 0.05, 0.5), -1);
    for (int row = 0; row < cells.frame().rows; ++row) {
      for (int column = 0; column < cells.frame().columns; ++column) {
        const Cell cell{column, row};
        for (const Polygon2& floor : floors_)
          if (contains(floor, cells.frame().centre_of(cell))) cells[cell] = 0;
      }
    }
    for (const auto& [from, to] : faces_) {
      const int count = static_cast<int>((to - from).norm() / 0.01);
      for (int i = 0; i <= count; ++i)
        cells[cells.frame().cell_of(from + i * (to - from) / count)] = 100;
    }
    return cells;
  }

  [[nodiscard]] WallSamples samples() const {
    Rng rng(7);
    WallSamples samples{.common_sigma_m = 0.002, .from_scans = true};
    constexpr int kScans = 12;
    for (int scan = 0; scan < kScans; ++scan) {
      for (const auto& [from, to] : faces_) {
        const Eigen::Vector2d u = (to - from).normalized();
        const Eigen::Vector2d normal(-u.y(), u.x());
        for (double t = rng.uniform(0.0, 0.03); t < (to - from).norm(); t += 0.03) {
          const Eigen::Vector2d point = from + t * u + rng.normal(0.0, noise_m_) * normal;
          samples.samples.push_back(
              {.point = point.cast<float>(), .normal = normal.cast<float>(), .scan = scan});
        }
      }
    }
    return samples;
  }

  [[nodiscard]] VectorPlan plan() const { return extract_plan(cells(), samples()); }

 private:
  Pose2 map_T_scene_;
  double noise_m_;
  std::vector<Polygon2> floors_{};
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> faces_{};
};

/// Two rooms of 4 x 3 m beside each other, a wall of 0.12 m between them with a door of 0.9 m. One
/// floor: its outline goes through the door and back.
inline PlanScene two_rooms(const Pose2& map_T_scene = {}) {
  PlanScene scene(map_T_scene);
  scene.floor({{0.0, 0.0},
               {4.0, 0.0},
               {4.0, 1.0},
               {4.12, 1.0},
               {4.12, 0.0},
               {8.12, 0.0},
               {8.12, 3.0},
               {4.12, 3.0},
               {4.12, 1.9},
               {4.0, 1.9},
               {4.0, 3.0},
               {0.0, 3.0}});
  return scene;
}

}  // namespace loopstone::test
