#include "loopstone/registration/map_match.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "map_scene.hpp"
#include "registration/map_lattice_search.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

struct Scene {
  World world = test::room_with_cabinet();
  SurfaceIndex surfaces{world.plan};
  MapSearch search{true_map(world, 0.05)};
};

const Scene& room() {
  static const Scene scene;
  return scene;
}

TEST(MatchOnMap, FindsAScanAnywhereWithoutAGuess) {
  Rng rng(1);
  for (int trial = 0; trial < 12; ++trial) {
    const Pose2 truth = test::place_in(room().world, room().surfaces, {0.5, 0.5}, {9.0, 5.8}, rng);
    const auto match = match_on_map(test::scan_at(room().surfaces, truth, rng), room().search);
    ASSERT_TRUE(match.found()) << trial;
    EXPECT_TRUE(match.sure) << trial;
    EXPECT_TRUE(test::pose_near(match.poses[0].target_T_source, truth, 0.05, radians(0.5)));
    EXPECT_GT(match.poses[0].score, 0.8);
  }
}

TEST(MatchOnMap, FindsAScanFromABadGuess) {
  Rng rng(2);
  for (int trial = 0; trial < 30; ++trial) {
    const Pose2 truth = test::place_in(room().world, room().surfaces, {0.5, 0.5}, {9.0, 5.8}, rng);
    const SearchWindow window{{truth.x + rng.uniform(-0.7, 0.7), truth.y + rng.uniform(-0.7, 0.7),
                               truth.yaw + rng.uniform(-0.78, 0.78)},
                              0.8,
                              0.8};
    const auto match =
        match_on_map(test::scan_at(room().surfaces, truth, rng), room().search, window);
    ASSERT_TRUE(match.found()) << trial;
    EXPECT_TRUE(test::pose_near(match.poses[0].target_T_source, truth, 0.05, radians(0.5)));
  }
}

/// Two equal rooms so far apart, and a scan of the first one.
MapMatch match_in_equal_rooms(const Eigen::Vector2d& apart, double cell_m, const Pose2& truth,
                              Rng& rng) {
  World world;
  // A door joins them by a passage that the scans hardly see.
  for (const Eigen::Vector2d& at : {Eigen::Vector2d(0.0, 0.0), apart}) {
    test::add_room(world.plan, at.x(), at.y(), at.x() + 5.0, at.y() + 4.0);
    world.plan.boxes.push_back(test::block(at.x(), at.y() + 2.9, at.x() + 1.3, at.y() + 4.0));
  }
  world.map_T_start = {2.0, 2.0, 0.0};
  Grid<std::int8_t> map = true_map(world, cell_m);
  world.map_T_start = {2.0 + apart.x(), 2.0 + apart.y(), 0.0};
  const Grid<std::int8_t> other = true_map(world, cell_m);
  for (std::size_t i = 0; i < map.cells().size(); ++i)
    map.cells()[i] = std::max(map.cells()[i], other.cells()[i]);
  return match_on_map(test::scan_at(SurfaceIndex(world.plan), truth, rng), MapSearch(map));
}

TEST(MatchOnMap, TwoEqualRoomsAreNotSureAndBothAreListed) {
  Rng rng(3);
  const Pose2 truth{1.9, 1.5, 0.4};
  const auto match = match_in_equal_rooms({7.0, 0.0}, 0.05, truth, rng);
  ASSERT_GE(match.poses.size(), 2U);
  EXPECT_FALSE(match.sure);
  for (const Pose2& expected : {truth, Pose2{truth.x + 7.0, truth.y, truth.yaw}}) {
    EXPECT_TRUE(std::any_of(match.poses.begin(), match.poses.begin() + 2, [&](const auto& pose) {
      return bool(test::pose_near(pose.target_T_source, expected, 0.05, radians(0.5)));
    }));
  }
}

TEST(MatchOnMap, EqualRoomsAreNotSureHoweverTheirWallsLieOnTheCells) {
  Rng rng(7);
  for (const double cell_m : {0.05, 0.10}) {
    for (int trial = 0; trial < 20; ++trial) {
      const Eigen::Vector2d apart(7.0 + rng.uniform(0.0, cell_m), rng.uniform(0.0, cell_m));
      const Pose2 truth{rng.uniform(1.6, 3.5), rng.uniform(1.0, 2.5), rng.uniform(-3.0, 3.0)};
      const auto match = match_in_equal_rooms(apart, cell_m, truth, rng);
      ASSERT_GE(match.poses.size(), 2U);
      EXPECT_FALSE(match.sure) << cell_m << ' ' << apart.transpose();
    }
  }
}

TEST(MatchOnMap, AScanOfAnotherPlaceIsNotSure) {
  World elsewhere;
  test::add_room(elsewhere.plan, 0.0, 0.0, 3.0, 14.0);
  Rng rng(4);
  const auto scan = test::scan_at(SurfaceIndex(elsewhere.plan), {1.0, 9.0, 0.2}, rng);
  EXPECT_FALSE(match_on_map(scan, room().search).sure);
  EXPECT_FALSE(match_on_map({}, room().search).found());
  const SearchWindow off_the_map{{500.0, 0.0, 0.0}, 1.0, 0.5};
  EXPECT_FALSE(match_on_map(scan, room().search, off_the_map).found());
}

/// All poses of the lattice, one after the other; the best of each block of 8 x 8 cells that
/// counts.
std::map<std::tuple<int, int, int>, int> exhaustive(const std::vector<Eigen::Vector2d>& points,
                                                    const MapSearch& map, const MapLattice& lattice,
                                                    double min_score, double margin) {
  const GridFrame& frame = map.pyramid().frame();
  std::map<std::tuple<int, int, int>, int> best_of_block;
  int best = 0;
  for (int heading = 0; heading < static_cast<int>(lattice.headings.size()); ++heading) {
    for (int row = lattice.first.row; row <= lattice.last.row; ++row) {
      for (int column = lattice.first.column; column <= lattice.last.column; ++column) {
        if (map.standable()[{column, row}] == 0) continue;
        const Eigen::Vector2d at = frame.centre_of({column, row});
        const Pose2 pose{at.x(), at.y(), lattice.headings[static_cast<std::size_t>(heading)]};
        int sum = 0;
        for (const auto& point : points) {
          const Cell cell = frame.cell_of(pose * point);
          sum += map.pyramid().bound(0, cell.column, cell.row);
        }
        int& in_block = best_of_block[{heading, (row - lattice.first.row) / 8,
                                       (column - lattice.first.column) / 8}];
        in_block = std::max(in_block, sum);
        best = std::max(best, sum);
      }
    }
  }
  const auto count = static_cast<double>(points.size());
  std::erase_if(best_of_block, [&](const auto& entry) {
    const double score = (entry.second / count - kUnknown) / (kSurface - kUnknown);
    const double best_score = (best / count - kUnknown) / (kSurface - kUnknown);
    return score < min_score - 1e-9 || score < best_score - margin - 1e-9;
  });
  return best_of_block;
}

TEST(MapLatticeSearch, ListsExactlyTheBlocksThatCount) {
  Rng rng(5);
  for (int trial = 0; trial < 6; ++trial) {
    const Pose2 truth = test::place_in(room().world, room().surfaces, {0.5, 0.5}, {9.0, 5.8}, rng);
    std::vector<Eigen::Vector2d> points;
    for (const auto& point : test::scan_at(room().surfaces, truth, rng)) {
      if (rng.below(15) == 0) points.push_back(point);
    }
    const SearchWindow window{{truth.x + 0.3, truth.y - 0.2, truth.yaw + 0.2}, 1.5, 0.6};
    const MapLattice lattice = make_map_lattice(points, room().search, window);
    const double margin = 0.25;
    const auto expected = exhaustive(points, room().search, lattice, 0.1, margin);
    const auto found = search_map_lattice(points, room().search, lattice, 0.1, margin);
    ASSERT_EQ(found.poses.size(), expected.size()) << trial;
    int best = 0;
    for (const auto& [block, sum] : expected) best = std::max(best, sum);
    const double score =
        (best / static_cast<double>(points.size()) - kUnknown) / (kSurface - kUnknown);
    EXPECT_DOUBLE_EQ(found.poses.front().score, score);
    EXPECT_TRUE(std::is_sorted(found.poses.begin(), found.poses.end(),
                               [](const auto& a, const auto& b) { return a.score > b.score; }));
  }
}

TEST(MapLatticeSearch, TheFullCircleIsCoveredOnce) {
  const std::vector<Eigen::Vector2d> points{{3.0, 0.0}, {0.0, 2.0}};
  const MapLattice lattice = make_map_lattice(points, room().search, std::nullopt);
  const double step = lattice.headings[1] - lattice.headings[0];
  EXPECT_LE(step * 3.0, room().search.pyramid().frame().resolution + 1e-12);
  EXPECT_NEAR(lattice.headings.back() + step, lattice.headings.front() + 2.0 * kPi, 1e-9);
}

}  // namespace
}  // namespace loopstone
