#include "loopstone/mapping/occupancy.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/grid/ray_walk.hpp"
#include "mapping/grazing_beams.hpp"

namespace loopstone {
namespace {

constexpr float kNothing = std::numeric_limits<float>::infinity();
constexpr float kBad = std::numeric_limits<float>::quiet_NaN();

LaserScan scan_of(std::vector<float> ranges, double angle_min = 0.0, double increment = 0.1) {
  LaserScan scan;
  scan.angle_min_rad = angle_min;
  scan.angle_increment_rad = increment;
  scan.range_min_m = 0.05;
  scan.range_max_m = 20.0;
  scan.ranges_m = std::move(ranges);
  return scan;
}

PosedScan at(const LaserScan& scan, const Pose2& pose) { return {&scan, pose, pose, pose}; }

double probability_at(const OccupancyMap& map, double x, double y) {
  return map.probability(map.log_odds.frame().cell_of({x, y}));
}
bool observed_at(const OccupancyMap& map, double x, double y) {
  return map.observed.value_or(map.log_odds.frame().cell_of({x, y}), 0) != 0;
}

TEST(OccupancyMap, BeamFreesItsWayAndMarksItsEnd) {
  const LaserScan scan = scan_of({2.02F});
  const std::vector<PosedScan> scans{at(scan, {0.01, 0.01, 0.0})};
  const OccupancyMap map = build_occupancy_map(scans, 0.0);
  EXPECT_NEAR(probability_at(map, 2.03, 0.01), 0.7, 1e-6);
  for (double x = 0.01; x < 1.98; x += 0.05)
    EXPECT_NEAR(probability_at(map, x, 0.01), 0.4, 1e-6) << x;
  EXPECT_FALSE(observed_at(map, 2.08, 0.01));
  EXPECT_FALSE(observed_at(map, 1.0, 0.06));
  EXPECT_EQ(probability_at(map, 1.0, 0.06), 0.5);
}

TEST(OccupancyMap, EvidenceAddsUpInLogOddsAndIsClamped) {
  const LaserScan scan = scan_of({2.02F});
  const std::vector<PosedScan> two(2, at(scan, {0.01, 0.01, 0.0}));
  const double odds = 0.7 / 0.3;
  EXPECT_NEAR(probability_at(build_occupancy_map(two, 0.0), 2.03, 0.01),
              odds * odds / (1.0 + odds * odds), 1e-6);
  const std::vector<PosedScan> many(100, at(scan, {0.01, 0.01, 0.0}));
  const OccupancyMap map = build_occupancy_map(many, 0.0);
  EXPECT_NEAR(probability_at(map, 2.03, 0.01), 0.97, 1e-6);
  EXPECT_NEAR(probability_at(map, 1.0, 0.01), 0.03, 1e-6);
}

TEST(OccupancyMap, NoReturnCarvesUpToTheBoundAndBadBeamsSayNothing) {
  const LaserScan scan = scan_of({kNothing, kBad, -kNothing, 0.0F, -1.0F, 0.01F, 25.0F}, 0.0, 0.7);
  OccupancyOptions options;
  options.no_return_carve_m = 3.0;
  const std::vector<PosedScan> scans{at(scan, {0.025, 0.025, 0.0})};
  const OccupancyMap map = build_occupancy_map(scans, 0.0, options);
  int observed = 0;
  for (const auto cell : map.observed.cells()) observed += cell;
  EXPECT_EQ(observed, 61);  // 3 m of one row, both end cells included
  EXPECT_LT(probability_at(map, 3.0, 0.025), 0.5);
  for (const float value : map.log_odds.cells()) EXPECT_LE(value, 0.0F);
}

TEST(OccupancyMap, ReturnBeyondTheTrustedRangeCountsAsNoReturn) {
  const LaserScan scan = scan_of({12.0F});
  OccupancyOptions options;
  options.max_range_m = 10.0;
  const std::vector<PosedScan> scans{at(scan, {0.0, 0.0, 0.0})};
  const OccupancyMap map = build_occupancy_map(scans, 0.0, options);
  EXPECT_TRUE(observed_at(map, 4.9, 0.0));
  EXPECT_FALSE(observed_at(map, 6.0, 0.0));
}

TEST(OccupancyMap, EndPointWinsOverPassThroughWithinAScan) {
  // Many beams graze the wall cell in which the first one ends.
  const LaserScan scan = scan_of({2.0F, 5.0F, 5.0F, 5.0F, 5.0F}, 0.0, 0.001);
  const std::vector<PosedScan> scans{at(scan, {0.01, 0.01, 0.0})};
  EXPECT_NEAR(probability_at(build_occupancy_map(scans, 0.0), 2.01, 0.01), 0.7, 1e-6);
}

TEST(OccupancyMap, FootprintIsFreeWhateverWasMeasuredThere) {
  const LaserScan scan = scan_of({0.2F, 4.0F}, 0.0, 1.0);  // the first beam hits the robot itself
  std::vector<PosedScan> scans;
  for (int i = 0; i < 20; ++i) scans.push_back(at(scan, {0.1 * i, 0.0, 0.0}));
  const OccupancyMap map = build_occupancy_map(scans, 0.25);
  for (double x = -0.2; x < 2.1; x += 0.05) {
    EXPECT_NEAR(probability_at(map, x, 0.0), 0.03, 1e-6) << x;
    EXPECT_TRUE(observed_at(map, x, 0.15)) << x;
  }
  EXPECT_FALSE(observed_at(map, 1.0, -0.4));
}

TEST(OccupancyMap, FastRobotLeavesNoGapsButAJumpIsNotJoined) {
  const LaserScan scan = scan_of({kBad});
  const std::vector<PosedScan> scans{at(scan, {0, 0, 0}), at(scan, {0.9, 0, 0}),
                                     at(scan, {5.0, 0, 0})};
  const OccupancyMap map = build_occupancy_map(scans, 0.2);
  EXPECT_TRUE(observed_at(map, 0.45, 0.0));
  EXPECT_FALSE(observed_at(map, 3.0, 0.0));
  EXPECT_TRUE(observed_at(map, 5.0, 0.0));
}

TEST(OccupancyMap, SweepIsUndone) {
  // The lidar turns by 0.5 rad and drives 1 m during the sweep; all five beams see the same point.
  const Pose2 begin{0.0, 0.0, 0.1};
  const Pose2 end{1.0, 0.2, 0.6};
  const Eigen::Vector2d seen(3.02, 1.52);
  LaserScan scan = scan_of({0, 0, 0, 0, 0});
  std::vector<float> ranges;
  double first_angle = 0.0;
  double last_angle = 0.0;
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector2d local = (i == 0 ? begin : end).inverse() * seen;
    ranges.push_back(static_cast<float>(local.norm()));
    (i == 0 ? first_angle : last_angle) = std::atan2(local.y(), local.x());
  }
  scan.angle_min_rad = first_angle;
  scan.angle_increment_rad = (last_angle - first_angle) / 4.0;
  scan.ranges_m = {ranges[0], kBad, kBad, kBad, ranges[1]};
  const std::vector<PosedScan> scans{{&scan, begin, end, begin}};
  const OccupancyMap map = build_occupancy_map(scans, 0.0);
  EXPECT_NEAR(probability_at(map, seen.x(), seen.y()), 0.7, 1e-6);
  int occupied = 0;
  for (const float value : map.log_odds.cells()) occupied += value > 0.0F ? 1 : 0;
  EXPECT_EQ(occupied, 1);
  // The middle beam starts half-way along the arc.
  scan.ranges_m = {kBad, kBad, 2.0F, kBad, kBad};
  const Pose2 middle = interpolate(begin, end, 0.5);
  const double angle = scan.angle_rad(2);
  const Eigen::Vector2d hit =
      middle * Eigen::Vector2d(2.0 * std::cos(angle), 2.0 * std::sin(angle));
  EXPECT_NEAR(probability_at(build_occupancy_map(scans, 0.0), hit.x(), hit.y()), 0.7, 1e-6);
}

TEST(OccupancyMap, FarBeamsThatGrazeAWallDontWearAwayWhatNearOnesDrew) {
  // A wall whose face lies deep in its cells, seen once from beside it and fifty times from afar.
  constexpr double kWallY = 1.04;
  const auto from = [](double x) {
    std::vector<float> ranges;
    for (int i = 1; i < 180; ++i)
      ranges.push_back(static_cast<float>(kWallY / std::sin(i * kPi / 180.0)));
    return std::pair(scan_of(std::move(ranges), kPi / 180.0, kPi / 180.0), Pose2{x, 0.0, 0.0});
  };
  const auto near = from(0.0);
  const auto far = from(10.0);
  std::vector<PosedScan> scans{at(near.first, near.second)};
  scans.insert(scans.end(), 50, at(far.first, far.second));
  const OccupancyMap map = build_occupancy_map(scans, 0.0);
  for (double x = -0.5; x < 0.5; x += 0.05) EXPECT_GT(probability_at(map, x, kWallY), 0.5) << x;
  for (double x = -0.5; x < 9.0; x += 0.05)
    EXPECT_LE(probability_at(map, x, 0.5), 0.5) << "floor at " << x;
}

TEST(OccupancyMap, NothingSeenIsOneUnknownCell) {
  const OccupancyMap map = build_occupancy_map({}, 0.25);
  EXPECT_EQ(map.log_odds.cells().size(), 1U);
  EXPECT_EQ(map.observed.cells().front(), 0);
}

TEST(OccupancyMap, TooManyCellsBecomeWiderOnesAndThatIsSaid) {
  const LaserScan scan = scan_of({1.0F});
  const std::vector<PosedScan> scans{at(scan, {0, 0, 0}), at(scan, {100.0, 60.0, 0})};
  OccupancyOptions options;
  const OccupancyMap fine = build_occupancy_map(scans, 0.25, options);
  EXPECT_FALSE(coarser_than_asked(fine, options).has_value());
  options.most_cells = fine.log_odds.cells().size() / 10;
  const OccupancyMap coarse = build_occupancy_map(scans, 0.25, options);
  EXPECT_DOUBLE_EQ(coarse.log_odds.frame().resolution, 0.2);
  EXPECT_LE(coarse.log_odds.cells().size(), options.most_cells);
  EXPECT_TRUE(observed_at(coarse, 100.5, 60.0));
  const auto said = coarser_than_asked(coarse, options);
  ASSERT_TRUE(said.has_value());
  EXPECT_NE(said->find("0.2 m wide"), std::string::npos) << *said;
  EXPECT_NE(said->find("not 0.05 m as asked"), std::string::npos) << *said;
  options.most_cells = 100;
  EXPECT_THROW((void)build_occupancy_map(scans, 0.25, options), UsageError);
}

TEST(OccupancyMap, AbsurdExtentIsRefusedWithAdvice) {
  const LaserScan scan = scan_of({1.0F});
  const std::vector<PosedScan> scans{at(scan, {0, 0, 0}), at(scan, {1e7, 1e7, 0})};
  EXPECT_THROW((void)build_occupancy_map(scans, 0.25), UsageError);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<PosedScan> lost{at(scan, {0, 0, 0}), at(scan, {nan, 0, 0})};
  EXPECT_LT(build_occupancy_map(lost, 0.25).log_odds.cells().size(), 1000U);
}

/// The definition, one scan at a time, with sets of cells and the ordered ray walk.
OccupancyMap naive_map(const std::vector<PosedScan>& scans, const GridFrame& frame,
                       const OccupancyOptions& options) {
  const auto log_odds = [](double p) { return static_cast<float>(std::log(p / (1.0 - p))); };
  const float limit = log_odds(options.clamp_probability);
  OccupancyMap map{Grid<float>(frame), Grid<std::uint8_t>(frame)};
  for (const PosedScan& posed : scans) {
    std::set<std::pair<int, int>> ends;
    std::set<std::pair<int, int>> passed;
    std::optional<std::pair<Cell, bool>> before;
    std::vector<Beam> beams;
    for (std::size_t i = 0; i < posed.scan->ranges_m.size(); ++i) {
      double range = posed.scan->ranges_m[i];
      if (std::isnan(range)) continue;
      const bool hit = std::isfinite(range) && range <= options.max_range_m;
      if (!hit) range = options.no_return_carve_m;
      const double angle = posed.scan->angle_rad(i);
      const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
      const Eigen::Vector2d start = posed.map_T_lidar.translation();
      beams.push_back({start, start + range * (posed.map_T_lidar.rotation() * direction), hit});
    }
    for (std::size_t i = 0; i < beams.size(); ++i) {
      const Cell last = frame.cell_of(beams[i].end);
      const std::pair ends_as(last, beams[i].hit);
      if (before == ends_as) continue;  // as its neighbour did
      before = ends_as;
      walk_ray(grid_point_of(frame, beams[i].start),
               grid_point_of(frame, free_end(beams, i, frame.resolution)), [&](Cell cell) {
                 passed.insert({cell.column, cell.row});
               });
      if (beams[i].hit) ends.insert({last.column, last.row});
    }
    for (const auto& [column, row] : ends) {
      float& value = map.log_odds[{column, row}];
      value = std::min(value + log_odds(options.hit_probability), limit);
      map.observed[{column, row}] = 1;
    }
    for (const auto& [column, row] : passed) {
      if (ends.contains({column, row})) continue;
      float& value = map.log_odds[{column, row}];
      value = std::max(value + log_odds(options.miss_probability), -limit);
      map.observed[{column, row}] = 1;
    }
  }
  return map;
}

struct RandomRun {
  std::vector<LaserScan> scans;
  std::vector<PosedScan> posed;
};

RandomRun random_run(std::uint64_t seed, int scans, int beams) {
  Rng rng(seed);
  RandomRun run;
  Pose2 pose{0.0, 0.0, 0.0};
  for (int s = 0; s < scans; ++s) {
    std::vector<float> ranges;
    for (int b = 0; b < beams; ++b) {
      const double kind = rng.uniform();
      const double wall = 4.0 + 2.0 * std::sin(0.05 * b + pose.yaw) + rng.normal(0.0, 0.02);
      ranges.push_back(kind < 0.05  ? kBad
                       : kind < 0.1 ? kNothing
                                    : static_cast<float>(kind < 0.12 ? 15.0 : wall));
    }
    run.scans.push_back(scan_of(std::move(ranges), -kPi, 2.0 * kPi / beams));
    pose = pose * Pose2{0.1, 0.0, rng.normal(0.0, 0.1)};
    run.posed.push_back({nullptr, pose, pose, pose});
  }
  for (std::size_t s = 0; s < run.posed.size(); ++s) run.posed[s].scan = &run.scans[s];
  return run;
}

TEST(OccupancyMap, EqualsTheNaiveTwin) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    // Some scans so fine that beams share most of their way.
    const RandomRun run = random_run(seed, 30, seed % 2 == 0 ? 90 : 1081);
    OccupancyOptions options;
    options.resolution_m = 0.04 + 0.02 * static_cast<double>(seed);
    options.max_range_m = 10.0;
    for (const int threads : {1, 3}) {
      const OccupancyMap map = build_occupancy_map(run.posed, 0.0, options, Threads{threads});
      const OccupancyMap naive = naive_map(run.posed, map.log_odds.frame(), options);
      ASSERT_EQ(map.observed.cells(), naive.observed.cells());
      ASSERT_EQ(map.log_odds.cells(), naive.log_odds.cells());
    }
  }
}

TEST(OccupancyMap, SameBytesForAnyNumberOfThreads) {
  RandomRun run = random_run(77, 700, 721);  // several batches
  for (PosedScan& posed : run.posed)
    posed.map_T_lidar_end = posed.map_T_lidar * Pose2{0.05, 0.0, 0.1};
  const OccupancyMap one = build_occupancy_map(run.posed, 0.25, {}, Threads{1});
  for (const int threads : {2, 5, 16}) {
    const OccupancyMap many = build_occupancy_map(run.posed, 0.25, {}, Threads{threads});
    ASSERT_EQ(one.log_odds.frame(), many.log_odds.frame());
    ASSERT_EQ(one.observed.cells(), many.observed.cells());
    ASSERT_EQ(0, std::memcmp(one.log_odds.cells().data(), many.log_odds.cells().data(),
                             one.log_odds.cells().size() * sizeof(float)));
  }
}

TEST(OccupancyMap, ScansInAnotherFrameGiveTheSameMapShifted) {
  const RandomRun run = random_run(5, 10, 60);
  auto shifted = run.posed;
  for (PosedScan& posed : shifted) {
    for (Pose2* pose : {&posed.map_T_lidar, &posed.map_T_lidar_end, &posed.map_T_robot})
      pose->x += 8.0;
  }
  const OccupancyMap here = build_occupancy_map(run.posed, 0.25);
  const OccupancyMap there = build_occupancy_map(shifted, 0.25);
  EXPECT_NEAR(there.log_odds.frame().origin.x() - here.log_odds.frame().origin.x(), 8.0, 0.051);
  std::map<bool, int> occupied;
  for (const float value : here.log_odds.cells()) occupied[true] += value > 0.0F ? 1 : 0;
  for (const float value : there.log_odds.cells()) occupied[false] += value > 0.0F ? 1 : 0;
  EXPECT_NEAR(occupied[true], occupied[false], 0.02 * occupied[true]);
}

}  // namespace
}  // namespace loopstone
