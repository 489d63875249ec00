#include "loopstone/grid/ray_cast.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/parallel_for.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

using Occupied = Grid<std::uint8_t>;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// When a coordinate that moves lies in the half-open cell [cell, cell + 1), as part of the ray.
struct Stay {
  double low = -kInfinity;
  double high = kInfinity;
  bool low_closed = true;
  bool high_closed = true;

  static Stay in_cell(double from, double speed, int cell) {
    if (std::abs(speed) < 1e-9) {
      if (from >= cell && from < cell + 1) return {};
      return {1.0, 0.0, true, true};
    }
    const double inverse = 1.0 / speed;
    const double one = (cell - from) * inverse;
    const double other = (cell + 1 - from) * inverse;
    return speed > 0.0 ? Stay{one, other, true, false} : Stay{other, one, false, true};
  }
  [[nodiscard]] Stay both(const Stay& that) const {
    Stay result;
    result.low = std::max(low, that.low);
    result.high = std::min(high, that.high);
    result.low_closed =
        (low < result.low || low_closed) && (that.low < result.low || that.low_closed);
    result.high_closed =
        (high > result.high || high_closed) && (that.high > result.high || that.high_closed);
    return result;
  }
  [[nodiscard]] bool empty() const {
    return low > high || (low == high && !(low_closed && high_closed));
  }
};

/// The definition itself: the least distance at which the ray is in some occupied cell. No walking.
double naive_range(const Occupied& occupied, const Ray& ray, double max_range_m) {
  const GridFrame& frame = occupied.frame();
  const double x = (ray.origin.x() - frame.origin.x()) / frame.resolution;
  const double y = (ray.origin.y() - frame.origin.y()) / frame.resolution;
  double nearest = kInfinity;
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      if (occupied[{column, row}] == 0) continue;
      const Stay stay = Stay{0.0, kInfinity, true, true}
                            .both(Stay::in_cell(x, ray.direction.x(), column))
                            .both(Stay::in_cell(y, ray.direction.y(), row));
      if (!stay.empty() && stay.low <= max_range_m / frame.resolution)
        nearest = std::min(nearest, stay.low);
    }
  }
  return nearest * frame.resolution;
}

/// Distance from a point to the nearest cell of a kind; cells outside are open.
double distance_to(const Occupied& occupied, bool wall, const Eigen::Vector2d& point) {
  const GridFrame& frame = occupied.frame();
  if (!wall && !frame.contains(frame.cell_of(point))) return 0.0;
  double nearest = kInfinity;
  for (int row = -1; row <= frame.rows; ++row) {
    for (int column = -1; column <= frame.columns; ++column) {
      if ((occupied.value_or({column, row}, 0) != 0) != wall) continue;
      const Eigen::Vector2d away =
          (point - frame.centre_of({column, row})).cwiseAbs().array() - 0.5 * frame.resolution;
      nearest = std::min(nearest, away.cwiseMax(0.0).norm());
    }
  }
  return nearest;
}

Occupied random_grid(Rng& rng) {
  const double densities[] = {0.0, 0.01, 0.05, 0.3, 0.9};
  const double resolutions[] = {0.05, 0.1, 0.5, 1.0, 0.037};
  const GridFrame frame{.origin = {rng.uniform(-5.0, 5.0), rng.uniform(-5.0, 5.0)},
                        .resolution = resolutions[rng.below(5)],
                        .columns = 1 + static_cast<int>(rng.below(30)),
                        .rows = 1 + static_cast<int>(rng.below(30))};
  Occupied grid(rng.below(2) == 0 ? frame
                                  : GridFrame{.origin = {0.0, 0.0},
                                              .resolution = frame.resolution,
                                              .columns = frame.columns,
                                              .rows = frame.rows});
  const double density = densities[rng.below(5)];
  for (auto& cell : grid.cells()) cell = rng.uniform() < density ? 1 : 0;
  return grid;
}

/// From cell corners, edges, centres and anywhere, inside and outside; along axes, diagonals,
/// through corners and anyhow.
Ray random_ray(const GridFrame& frame, Rng& rng) {
  const auto coordinate = [&](double low, int cells) {
    const auto cell = static_cast<double>(rng.below(static_cast<std::uint64_t>(cells) + 9)) - 4.0;
    const double parts[] = {0.0, 0.0, 0.5, 1e-12, rng.uniform(), rng.uniform()};
    return low + (cell + parts[rng.below(6)]) * frame.resolution;
  };
  const Eigen::Vector2d origin{coordinate(frame.origin.x(), frame.columns),
                               coordinate(frame.origin.y(), frame.rows)};
  const double heading = rng.uniform(-kPi, kPi);
  const auto sign = [&] { return rng.below(2) == 0 ? 1.0 : -1.0; };
  switch (rng.below(6)) {
    case 0:
      return {origin, {sign(), 0.0}};
    case 1:
      return {origin, {0.0, sign()}};
    case 2:
      return {origin, {sign() * std::numbers::sqrt2 / 2, sign() * std::numbers::sqrt2 / 2}};
    case 3:  // 3-4-5: corners again and again
      return {origin, {sign() * 0.6, sign() * 0.8}};
    case 4:
      return {origin, {sign(), rng.uniform(-1e-8, 1e-8)}};
    default:
      return {origin, {std::cos(heading), std::sin(heading)}};
  }
}

double random_max_range(const GridFrame& frame, Rng& rng) {
  const double cells[] = {0.3, 1.0, 7.0, 25.0, 500.0};
  return cells[rng.below(5)] * frame.resolution;
}

std::vector<float> ranges_of(const RayCaster& caster, std::span<const Ray> rays) {
  std::vector<float> ranges(rays.size());
  caster.ranges(rays, ranges);
  return ranges;
}

std::vector<float> ranges_of(const RayCaster& caster, const ScanRays& rays) {
  std::vector<float> ranges(rays.size());
  caster.ranges(rays, ranges);
  return ranges;
}

RC_GTEST_PROP(RayCastLaws, WalkIsTheDefinition, (std::uint64_t seed)) {
  Rng rng(seed);
  const Occupied grid = random_grid(rng);
  const double max_range_m = random_max_range(grid.frame(), rng);
  const WalkCaster walk(grid, max_range_m);
  for (int i = 0; i < 40; ++i) {
    const Ray ray = random_ray(grid.frame(), rng);
    RC_ASSERT(walk.range(ray) == naive_range(grid, ray, max_range_m));
  }
}

RC_GTEST_PROP(RayCastLaws, SphereTracingIsTheWalkToTheBit, (std::uint64_t seed)) {
  Rng rng(seed);
  const Occupied grid = random_grid(rng);
  const double max_range_m = random_max_range(grid.frame(), rng);
  const WalkCaster walk(grid, max_range_m);
  const SphereCaster sphere(grid, max_range_m);
  std::vector<Ray> rays;
  for (int i = 0; i < 300; ++i) rays.push_back(random_ray(grid.frame(), rng));
  const auto ranges = ranges_of(sphere, rays);
  RC_ASSERT(ranges == ranges_of(walk, rays));
  for (std::size_t i = 0; i < rays.size(); ++i) {
    RC_ASSERT(static_cast<float>(walk.range(rays[i])) == ranges[i]);
    RC_ASSERT(sphere.range(rays[i]) == static_cast<double>(ranges[i]));
  }
}

RC_GTEST_PROP(RayCastLaws, BeamsOfScansAreRays, (std::uint64_t seed)) {
  Rng rng(seed);
  const Occupied grid = random_grid(rng);
  const double max_range_m = random_max_range(grid.frame(), rng);
  const RayCaster casters[] = {WalkCaster(grid, max_range_m), SphereCaster(grid, max_range_m),
                               TableCaster(grid, max_range_m, {}, {.headings = 16})};
  std::vector<Pose2> poses;
  std::vector<double> angles_rad;
  for (std::uint64_t i = rng.below(12); i > 0; --i) {
    const Ray ray = random_ray(grid.frame(), rng);
    poses.push_back({ray.origin.x(), ray.origin.y(), rng.uniform(-kPi, kPi)});
  }
  for (std::uint64_t i = rng.below(40); i > 0; --i) angles_rad.push_back(rng.uniform(-7.0, 7.0));
  std::vector<Ray> rays;
  for (const Pose2& pose : poses) {
    const double c = std::cos(pose.yaw);
    const double s = std::sin(pose.yaw);
    for (const double angle : angles_rad) {
      rays.push_back(
          {pose.translation(),
           {c * std::cos(angle) - s * std::sin(angle), s * std::cos(angle) + c * std::sin(angle)}});
    }
  }
  for (const RayCaster& caster : casters) {
    RC_ASSERT(ranges_of(caster, ScanRays{poses, angles_rad}) == ranges_of(caster, rays));
  }
}

RC_GTEST_PROP(RayCastLaws, TableAnswersTheLineThatItSaysExactly, (std::uint64_t seed)) {
  Rng rng(seed);
  const Occupied grid = random_grid(rng);
  const double max_range_m = random_max_range(grid.frame(), rng);
  const TableCaster table(grid, max_range_m, {}, {.headings = 4 + static_cast<int>(rng.below(60))});
  const double far_m = max_range_m + grid.frame().resolution;
  for (int i = 0; i < 60; ++i) {
    const Ray ray = random_ray(grid.frame(), rng);
    const double range_m = table.range(ray);
    const TableCaster::Answered answered = table.answered(ray);
    if (!answered.tabulated) {
      RC_ASSERT(range_m ==
                static_cast<double>(static_cast<float>(naive_range(grid, ray, max_range_m))));
      continue;
    }
    RC_ASSERT(ray.direction.dot(answered.ray_from_centre.direction) > 0.0);
    const double from_centre_m = naive_range(grid, answered.ray_from_centre, far_m);
    const double expected_m =
        from_centre_m == 0.0 ? 0.0 : std::max(from_centre_m - answered.ahead_m, 0.0);
    const double tolerance_m = 0.5 * table.range_quantum_m() + 1e-5 * (1.0 + max_range_m);
    if (std::isinf(range_m)) {
      RC_ASSERT(expected_m >= max_range_m - tolerance_m);
    } else {
      RC_ASSERT(std::abs(range_m - expected_m) <= tolerance_m);
    }
  }
}

RC_GTEST_PROP(RayCastLaws, TableStaysWithinItsBound, (std::uint64_t seed)) {
  Rng rng(seed);
  const Occupied grid = random_grid(rng);
  const double max_range_m = 100.0 * grid.frame().resolution;
  const TableCaster table(grid, max_range_m, {},
                          {.headings = 16 + static_cast<int>(rng.below(400))});
  for (int i = 0; i < 10; ++i) {
    const Ray ray = random_ray(grid.frame(), rng);
    const double range_m = table.range(ray);
    if (std::isfinite(range_m)) {  // what it hits is near the ray
      const Eigen::Vector2d hit = ray.origin + range_m * ray.direction;
      RC_ASSERT(distance_to(grid, true, hit) <= table.stray_m(range_m));
    }
    const double seen_m = std::min(range_m, 40.0 * grid.frame().resolution);
    const double clear_m = seen_m - table.stray_m(seen_m);
    for (int k = 0; k < 10 && clear_m > 0.0; ++k) {  // and it never goes through a thing's inside
      const double at_m = rng.uniform(0.0, clear_m);
      RC_ASSERT(distance_to(grid, false, ray.origin + at_m * ray.direction) <= table.stray_m(at_m));
    }
  }
}

/// Rooms with doors: long rays beside walls.
Occupied building() {
  Occupied grid(GridFrame{.origin = {-3.0, 1.0}, .resolution = 0.05, .columns = 160, .rows = 120});
  for (int row = 0; row < 120; ++row) {
    for (int column = 0; column < 160; ++column) {
      const bool wall = column % 53 == 0 || row % 39 == 0;
      const bool door = column % 31 < 10 && row % 37 < 12;
      if (wall && !door) grid[{column, row}] = 1;
    }
  }
  return grid;
}

TEST(RayCast, CastersAgreeInABuilding) {
  const Occupied grid = building();
  const WalkCaster walk(grid, 12.0);
  const SphereCaster sphere(grid, 12.0);
  const TableCaster table(grid, 12.0, {}, {.headings = 64});
  Rng rng(3);
  std::vector<Ray> rays;
  for (int i = 0; i < 20000; ++i) {
    rays.push_back(
        ray_along({rng.uniform(-3.0, 5.0), rng.uniform(1.0, 7.0), rng.uniform(-kPi, kPi)}));
  }
  const auto exact = ranges_of(walk, rays);
  EXPECT_EQ(ranges_of(sphere, rays), exact);
  const auto looked_up = ranges_of(table, rays);
  std::vector<double> errors;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (std::isfinite(exact[i]) && std::isfinite(looked_up[i])) {
      errors.push_back(std::abs(static_cast<double>(exact[i] - looked_up[i])));
    }
  }
  ASSERT_GT(errors.size(), 10000U);
  std::nth_element(errors.begin(), errors.begin() + 5000, errors.end());
  EXPECT_LT(errors[5000], 0.05);  // typically a cell
}

TEST(RayCast, KnownRanges) {
  Occupied grid(GridFrame{.origin = {0.0, 0.0}, .resolution = 0.5, .columns = 10, .rows = 4});
  grid[{6, 1}] = 1;  // x in [3, 3.5), y in [0.5, 1)
  const RayCaster casters[] = {WalkCaster(grid, 5.0), SphereCaster(grid, 5.0)};
  for (const RayCaster& caster : casters) {
    EXPECT_EQ(caster.range({{1.0, 0.75}, {1.0, 0.0}}), 2.0);
    EXPECT_EQ(caster.range({{3.2, 0.75}, {1.0, 0.0}}), 0.0) << "starts in it";
    EXPECT_EQ(caster.range({{4.0, 0.75}, {-1.0, 0.0}}), 0.5);
    EXPECT_EQ(caster.range({{1.0, 0.5}, {1.0, 0.0}}), 2.0) << "its lower edge is its own";
    EXPECT_EQ(caster.range({{1.0, 1.0}, {1.0, 0.0}}), kInfinity) << "its upper edge is not";
    EXPECT_EQ(caster.range({{-2.0, 0.75}, {1.0, 0.0}}), 5.0) << "comes in from outside";
    EXPECT_EQ(caster.range({{-2.1, 0.75}, {1.0, 0.0}}), kInfinity) << "too far";
    EXPECT_EQ(caster.range({{4.0, 0.75}, {1.0, 0.0}}), kInfinity) << "leaves the map";
    EXPECT_EQ(caster.range({{3.25, -1.0}, {0.0, 1.0}}), 1.5);
    EXPECT_EQ(caster.max_range_m(), 5.0);
  }
}

TEST(RayCast, NoNumberNoHit) {
  const Occupied grid = building();
  const RayCaster casters[] = {WalkCaster(grid, 5.0), SphereCaster(grid, 5.0),
                               TableCaster(grid, 5.0, {}, {.headings = 4})};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const RayCaster& caster : casters) {
    for (const double bad : {nan, kInfinity, -kInfinity, 1e300, -1e300}) {
      EXPECT_EQ(caster.range({{bad, 2.0}, {1.0, 0.0}}), kInfinity);
      EXPECT_EQ(caster.range({{2.0, bad}, {1.0, 0.0}}), kInfinity);
    }
  }
  for (const RayCaster& caster : {casters[0], casters[1]}) {
    for (const double bad : {nan, kInfinity, -kInfinity, 1e300}) {
      EXPECT_EQ(caster.range({{2.0, 2.0}, {bad, 0.0}}), kInfinity);
      EXPECT_EQ(caster.range({{2.0, 2.0}, {0.0, bad}}), kInfinity);
    }
  }
  std::vector<float> ranges(1);
  const Pose2 nowhere{2.0, 2.0, nan};
  const double angle = nan;
  for (const RayCaster& caster : casters) {
    caster.ranges(ScanRays{{&nowhere, 1}, {&angle, 1}}, ranges);  // any answer, no damage
    caster.ranges(std::vector<Ray>{{{2.0, 2.0}, {nan, nan}}}, ranges);
  }
}

TEST(RayCast, EmptyMapsHaveNothingToHit) {
  for (const Occupied& grid : {Occupied{}, Occupied(GridFrame{.columns = 5, .rows = 5})}) {
    const RayCaster casters[] = {WalkCaster(grid, 5.0), SphereCaster(grid, 5.0),
                                 TableCaster(grid, 5.0, {}, {.headings = 4})};
    for (const RayCaster& caster : casters) {
      EXPECT_EQ(caster.range({{0.1, 0.1}, {1.0, 0.0}}), kInfinity);
      caster.ranges(std::span<const Ray>{}, {});
      caster.ranges(ScanRays{}, {});
    }
  }
}

TEST(RayCast, RejectsWhatCannotBe) {
  const Occupied grid = building();
  EXPECT_THROW(WalkCaster(grid, 0.0), UsageError);
  EXPECT_THROW(SphereCaster(grid, kInfinity), UsageError);
  EXPECT_THROW(TableCaster(grid, -1.0), UsageError);
  EXPECT_THROW(TableCaster(grid, 5.0, {}, {.headings = 3}), UsageError);
  EXPECT_THROW(TableCaster(grid, 5.0, Occupied(GridFrame{.columns = 2, .rows = 2})), UsageError);
  const std::vector<Ray> rays(3, Ray{{0.0, 2.0}, {1.0, 0.0}});
  const std::vector<Pose2> poses(2);
  const std::vector<double> angles_rad(4);
  std::vector<float> two(2);
  for (const RayCaster& caster :
       {RayCaster(WalkCaster(grid, 5.0)), RayCaster(SphereCaster(grid, 5.0)),
        RayCaster(TableCaster(grid, 5.0, {}, {.headings = 4}))}) {
    EXPECT_THROW(caster.ranges(rays, two), UsageError);
    EXPECT_THROW(caster.ranges(ScanRays{poses, angles_rad}, two), UsageError);
  }
}

TEST(RayCast, TableHoldsOnlyWhereRaysStart) {
  const Occupied grid = building();
  Occupied origins(grid.frame());
  for (int row = 20; row < 50; ++row) {
    for (int column = 40; column < 60; ++column) origins[{column, row}] = 1;
  }
  const TableCaster all(grid, 8.0, {}, {.headings = 32});
  const TableCaster some(grid, 8.0, origins, {.headings = 32});
  EXPECT_LT(some.memory_bytes(), all.memory_bytes() / 5);
  EXPECT_GE(some.memory_bytes(), 30U * 20U * 32U * 2U);
  const WalkCaster walk(grid, 8.0);
  Rng rng(9);
  int inside = 0;
  for (int i = 0; i < 3000; ++i) {
    const Ray ray =
        ray_along({rng.uniform(-3.0, 5.0), rng.uniform(1.0, 6.0), rng.uniform(-kPi, kPi)});
    if (some.answered(ray).tabulated) {
      ++inside;
      ASSERT_EQ(some.range(ray), all.range(ray));
    } else {
      ASSERT_EQ(some.range(ray), static_cast<double>(static_cast<float>(walk.range(ray))));
    }
  }
  EXPECT_GT(inside, 100);
}

TEST(RayCast, AnyNumberOfThreadsBuildsAndCastsAlike) {
  const Occupied grid = building();
  Occupied origins(grid.frame());
  for (int column = 40; column < 80; ++column) origins[{column, 50}] = 1;
  const RayCaster one[] = {SphereCaster(grid, 8.0, Threads{1}),
                           TableCaster(grid, 8.0, origins, {.headings = 64}, Threads{1})};
  const RayCaster many[] = {SphereCaster(grid, 8.0, Threads{3}),
                            TableCaster(grid, 8.0, origins, {.headings = 64}, Threads{3})};
  std::vector<Pose2> poses;
  Rng rng(4);
  for (int i = 0; i < 200; ++i) {
    poses.push_back({rng.uniform(-1.0, 1.0), 3.52, rng.uniform(-kPi, kPi)});
  }
  const std::vector<double> angles_rad{-1.0, 0.0, 0.3, 2.0, 3.0};
  for (int i = 0; i < 2; ++i) {
    const auto expected = ranges_of(one[i], ScanRays{poses, angles_rad});
    std::vector<float> ranges(expected.size());
    parallel_for(poses.size(), Threads{3}, [&](std::size_t pose) {
      many[i].ranges(ScanRays{std::span<const Pose2>(poses).subspan(pose, 1), angles_rad},
                     std::span<float>(ranges).subspan(pose * angles_rad.size(), angles_rad.size()));
    });
    EXPECT_EQ(ranges, expected);
  }
}

}  // namespace
}  // namespace loopstone
