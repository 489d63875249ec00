#include "loopstone/registration/correspondences.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/registration/icp_cloud.hpp"
#include "loopstone/sensor/scan_points.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

template <int kDimension>
using Vector = Eigen::Matrix<double, kDimension, 1>;
template <int kDimension>
using Points = std::vector<Vector<kDimension>>;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// All points, one after the other: what every search must agree with.
template <int kDimension>
NearestPoint brute_force(const Points<kDimension>& points, const Vector<kDimension>& query,
                         double max_distance_m) {
  NearestPoint nearest{-1, std::numeric_limits<double>::infinity(), max_distance_m};
  if (!query.allFinite()) return nearest;
  for (std::size_t i = 0; i < points.size(); ++i) {
    double squared = 0.0;
    for (int k = 0; k < kDimension; ++k) {
      squared += (points[i](k) - query(k)) * (points[i](k) - query(k));
    }
    if (squared <= max_distance_m * max_distance_m && squared < nearest.squared_distance_m2) {
      nearest.index = static_cast<std::int32_t>(i);
      nearest.squared_distance_m2 = squared;
    }
  }
  if (nearest.index < 0) return nearest;
  nearest.others_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (static_cast<std::int32_t>(i) == nearest.index || !points[i].allFinite()) continue;
    nearest.others_m = std::min(nearest.others_m, (points[i] - query).norm());
  }
  return nearest;
}

/// Points in clusters, on a line, on a lattice (many ties), far away, and some that are none.
template <int kDimension>
Points<kDimension> motley_points(Rng& rng) {
  Points<kDimension> points;
  const auto random = [&](double size) {
    Vector<kDimension> point;
    for (int k = 0; k < kDimension; ++k) point(k) = rng.uniform(-size, size);
    return point;
  };
  for (int cluster = 0; cluster < 5; ++cluster) {
    const Vector<kDimension> centre = random(3.0);
    for (int i = 0; i < 20; ++i) points.push_back(centre + random(0.1));
  }
  for (int i = 0; i < 60; ++i) {
    Vector<kDimension> point = Vector<kDimension>::Constant(1.0);
    point(0) = 0.05 * i - 1.0;
    points.push_back(point);
  }
  for (int i = 0; i < 49; ++i) {
    Vector<kDimension> point = Vector<kDimension>::Zero();
    point(0) = i % 7;
    point(1) = i / 7 - 3;
    points.push_back(point);
  }
  points.push_back(random(500.0));
  points.push_back(Vector<kDimension>::Constant(kNan));
  points.push_back(points.front());  // twice the same
  points.push_back(Vector<kDimension>::Zero());
  return points;
}

template <int kDimension>
Points<kDimension> motley_queries(const Points<kDimension>& points, Rng& rng) {
  Points<kDimension> queries = points;  // distance 0, and ties among neighbours
  for (int i = 0; i < 300; ++i) {
    Vector<kDimension> query;
    for (int k = 0; k < kDimension; ++k) query(k) = rng.uniform(-4.0, 4.0);
    queries.push_back(query);
    queries.push_back(0.5 * query.array().round().matrix());  // between points of the lattice
  }
  return queries;
}

template <int kDimension, typename Index>
void expect_like_brute_force(const Index& index, const Points<kDimension>& points, Rng& rng) {
  for (const double reach_m : {0.05, 0.6, 20.0}) {
    for (const auto& query : motley_queries<kDimension>(points, rng)) {
      const NearestPoint expected = brute_force<kDimension>(points, query, reach_m);
      const auto hint = static_cast<std::int32_t>(rng.below(100));
      for (const std::int32_t tried_hint : {-1, hint, expected.index}) {
        const NearestPoint found = index.nearest_point(query, reach_m, tried_hint);
        ASSERT_EQ(found.index, expected.index);
        if (found.index < 0) {
          EXPECT_LE(found.others_m, reach_m);
          continue;
        }
        EXPECT_DOUBLE_EQ(found.squared_distance_m2, expected.squared_distance_m2);
        // The promise is a lower bound, and not below the nearest one, or it would be of no use.
        EXPECT_LE(found.others_m, expected.others_m * (1.0 + 1e-12));
        EXPECT_GE(found.others_m, std::sqrt(found.squared_distance_m2) * (1.0 - 1e-9));
      }
    }
  }
}

TEST(Correspondences, ByKdTreeAreThoseOfBruteForce) {
  Rng rng(31);
  const auto planar = motley_points<2>(rng);
  expect_like_brute_force<2>(PointIndex<2>(planar), planar, rng);
  const auto spatial = motley_points<3>(rng);
  expect_like_brute_force<3>(PointIndex<3>(spatial), spatial, rng);
}

TEST(Correspondences, ByGridAreThoseOfBruteForce) {
  Rng rng(32);
  const auto planar = motley_points<2>(rng);
  for (const double cell_m : {0.07, 1.0}) {
    expect_like_brute_force<2>(CellIndex<2>(planar, cell_m), planar, rng);
  }
  const auto spatial = motley_points<3>(rng);
  expect_like_brute_force<3>(CellIndex<3>(spatial, 0.4), spatial, rng);
}

TEST(Correspondences, ByBearingAreThoseOfBruteForceEvenForPointsThatAreNoScan) {
  Rng rng(33);
  const auto points = motley_points<2>(rng);
  expect_like_brute_force<2>(BearingIndex(points), points, rng);
}

TEST(Correspondences, OfAScanAreAlikeInAllThreeWays) {
  const test::Scanner scanner;
  const auto target = scan_points(
      test::scan_from(test::furnished_room(), {4.0, 3.0, 0.3}, Pose2{}, scanner), Pose2{});
  const auto source = scan_points(
      test::scan_from(test::furnished_room(), {4.2, 3.1, 0.5}, Pose2{}, scanner), Pose2{});
  const PointIndex<2> tree(target);
  const CellIndex<2> cells(target, 0.1);
  const BearingIndex bearings(target);
  for (const auto& query : source) {
    const NearestPoint by_tree = tree.nearest_point(query, 0.5);
    const NearestPoint by_cells = cells.nearest_point(query, 0.5);
    const NearestPoint by_bearing = bearings.nearest_point(query, 0.5);
    EXPECT_EQ(by_tree.index, by_cells.index);
    EXPECT_EQ(by_tree.index, by_bearing.index);
    EXPECT_EQ(by_tree.squared_distance_m2, by_cells.squared_distance_m2);
    EXPECT_EQ(by_tree.squared_distance_m2, by_bearing.squared_distance_m2);
  }
}

TEST(Correspondences, OfNothingAreNone) {
  for (const Points<2>& nothing : {Points<2>{}, Points<2>(3, Vector<2>::Constant(kNan))}) {
    const Vector<2> query(1.0, 2.0);
    EXPECT_EQ(PointIndex<2>(nothing).nearest_point(query, 1e9).index, -1);
    EXPECT_EQ(CellIndex<2>(nothing, 0.1).nearest_point(query, 1e9).index, -1);
    EXPECT_EQ(BearingIndex(nothing).nearest_point(query, 1e9).index, -1);
  }
  const Points<2> one{{1.0, 2.0}};
  EXPECT_EQ(PointIndex<2>(one).nearest_point({kNan, 0.0}, 1e9).index, -1);
  EXPECT_EQ(CellIndex<2>(one, 0.1).nearest_point({kNan, 0.0}, 1e9).index, -1);
  EXPECT_EQ(BearingIndex(one).nearest_point({kNan, 0.0}, 1e9).index, -1);
}

TEST(IcpCloud, RefusesASearchThatIsNotForSpace) {
  IcpCloudOptions<3> spatial;
  spatial.search = PointSearch::kProjection;
  EXPECT_THROW((void)make_icp_cloud<3>({}, spatial), UsageError);
}

}  // namespace
}  // namespace loopstone
