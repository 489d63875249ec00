#include "loopstone/registration/surface_grid.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <utility>
#include <vector>

#include "loopstone/geometry/angle.hpp"
#include "support/generators.hpp"
#include "support/saved_state.hpp"

namespace loopstone {
namespace {

constexpr std::array<double, 2> kResolutions{0.1, 0.3};

/// The same rules, told slowly: for each cell the points themselves, in the order they came; sums
/// are made when asked.
class SlowSurfaceGrid {
 public:
  explicit SlowSurfaceGrid(double resolution_m) : resolution_m_(resolution_m) {}

  void insert(const Eigen::Vector2d& point, const Eigen::Vector2d& normal, double weight) {
    const auto [column, row] = cell_of(point);
    for (int r = row - 1; r <= row + 1; ++r) {
      for (int c = column - 1; c <= column + 1; ++c)
        cells_[{c, r}].push_back({point, normal, weight});
    }
  }

  [[nodiscard]] std::optional<SurfaceLine> line_near(const Eigen::Vector2d& point,
                                                     const Eigen::Vector2d& normal) const {
    const auto cell = cells_.find(cell_of(point));
    if (cell == cells_.end()) return {};
    struct Group {
      double weight = 0.0;
      Eigen::Vector2d point = Eigen::Vector2d::Zero();
      Eigen::Vector2d normal = Eigen::Vector2d::Zero();
    };
    std::vector<Group> groups;
    for (const auto& seen : cell->second) {
      Group* own = nullptr;
      for (auto& group : groups) {
        if (group.normal.normalized().dot(seen.normal) > 0.5) {
          own = &group;
          break;
        }
      }
      if (own == nullptr) {
        if (groups.size() == 2) continue;  // two surfaces a cell, first come first served
        own = &groups.emplace_back();
      }
      own->weight += seen.weight;
      own->point += seen.weight * seen.point;
      own->normal += seen.weight * seen.normal;
    }
    for (const auto& group : groups) {
      if (group.normal.normalized().dot(normal) > 0.5)
        return SurfaceLine{group.point / group.weight, group.normal.normalized()};
    }
    return {};
  }

 private:
  struct Seen {
    Eigen::Vector2d point;
    Eigen::Vector2d normal;
    double weight;
  };
  [[nodiscard]] std::pair<int, int> cell_of(const Eigen::Vector2d& point) const {
    return {static_cast<int>(std::floor(point.x() / resolution_m_)),
            static_cast<int>(std::floor(point.y() / resolution_m_))};
  }

  double resolution_m_;
  std::map<std::pair<int, int>, std::vector<Seen>> cells_{};
};

/// Normals within 10 deg of one of four directions: whether two surfaces are one is never a matter
/// of rounding.
rc::Gen<Eigen::Vector2d> any_normal() {
  return rc::gen::map(rc::gen::pair(rc::gen::inRange(0, 4), test::between(-10.0, 10.0)),
                      [](const auto& pick) {
                        const double angle = 0.5 * kPi * pick.first + radians(pick.second);
                        return Eigen::Vector2d(std::cos(angle), std::sin(angle));
                      });
}

RC_GTEST_PROP(SurfaceGridLaws, AgreesWithItsSlowTwin, ()) {
  const Pose2 grid_T_points = *test::any_pose2();
  SurfaceGrid grid(kResolutions);
  std::vector<SlowSurfaceGrid> twins{SlowSurfaceGrid(kResolutions[0]),
                                     SlowSurfaceGrid(kResolutions[1])};
  const auto near = test::between(-0.5, 0.5);  // few cells, so that many points share one
  const int count = *rc::gen::inRange(0, 60);
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d normal = *any_normal();
    const SurfacePoint surface{Eigen::Vector2d(*near, *near).cast<float>(), normal.cast<float>(),
                               *rc::gen::element(0.25F, 1.0F, 3.0F)};
    grid.insert({&surface, 1}, grid_T_points);
    for (auto& twin : twins) {
      twin.insert(grid_T_points * surface.position.cast<double>().eval(),
                  grid_T_points.rotation() * surface.normal.cast<double>(), surface.weight);
    }
  }
  for (int k = 0; k < 40; ++k) {
    const Eigen::Vector2d point =
        grid_T_points * Eigen::Vector2d(*test::between(-1.0, 1.0), *test::between(-1.0, 1.0));
    const Eigen::Vector2d normal = grid_T_points.rotation() * *any_normal();
    for (std::size_t level = 0; level < twins.size(); ++level) {
      const auto fast = grid.line_near(level, point, normal);
      const auto slow = twins[level].line_near(point, normal);
      RC_ASSERT(fast.has_value() == slow.has_value());
      if (!fast) continue;
      RC_ASSERT((fast->point - slow->point).norm() < 1e-4);
      RC_ASSERT((fast->normal - slow->normal).norm() < 1e-4);
    }
  }
}

TEST(SurfaceGrid, BothSidesOfAThinWallStayApart) {
  SurfaceGrid grid(kResolutions);
  std::vector<SurfacePoint> wall;
  for (int i = 0; i < 20; ++i) {
    const float along = 0.05F * static_cast<float>(i);
    wall.push_back({{1.00F, along}, {-1.0F, 0.0F}});
    wall.push_back({{1.02F, along}, {1.0F, 0.0F}});
  }
  grid.insert(wall, Pose2{});
  for (std::size_t level = 0; level < grid.level_count(); ++level) {
    const auto left = grid.line_near(level, {1.01, 0.5}, {-1.0, 0.0});
    const auto right = grid.line_near(level, {1.01, 0.5}, {1.0, 0.0});
    ASSERT_TRUE(left.has_value());
    ASSERT_TRUE(right.has_value());
    EXPECT_NEAR(left->point.x(), 1.00, 1e-5);
    EXPECT_NEAR(right->point.x(), 1.02, 1e-5);
    EXPECT_FALSE(grid.line_near(level, {1.01, 0.5}, {0.0, 1.0}).has_value());
  }
}

TEST(SurfaceGrid, KnowsNothingWhereNothingWasPut) {
  SurfaceGrid grid(kResolutions);
  EXPECT_EQ(grid.level_count(), 2U);
  EXPECT_EQ(grid.resolution_m(1), 0.3);
  EXPECT_FALSE(grid.line_near(0, {0.0, 0.0}, {1.0, 0.0}).has_value());
  const SurfacePoint single{{0.05F, 0.05F}, {1.0F, 0.0F}};
  grid.insert({&single, 1}, Pose2{});
  EXPECT_TRUE(grid.line_near(0, {0.19, -0.09}, {1.0, 0.0}).has_value()) << "a neighbour cell";
  EXPECT_FALSE(grid.line_near(0, {0.21, 0.05}, {1.0, 0.0}).has_value()) << "two cells away";
  EXPECT_TRUE(grid.line_near(1, {0.21, 0.05}, {1.0, 0.0}).has_value())
      << "a neighbour on the coarser level";
}

TEST(SurfaceGrid, ComesBackWithItsLevels) {
  SurfaceGrid grid(kResolutions);
  const SurfacePoint single{{0.05F, 0.05F}, {1.0F, 0.0F}};
  grid.insert({&single, 1}, Pose2{});
  const SurfaceGrid again = test::restored(grid, SurfaceGrid{});
  ASSERT_EQ(again.level_count(), 2U);
  EXPECT_EQ(again.resolution_m(1), 0.3);
  EXPECT_TRUE(again.line_near(1, {0.21, 0.05}, {1.0, 0.0}).has_value());
  EXPECT_EQ(test::state_of(again), test::state_of(grid));
}

}  // namespace
}  // namespace loopstone
