#include "loopstone/slam/mapper.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "loopstone/geometry/angle.hpp"
#include "ring_world.hpp"
#include "support/pose_near.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

using test::pose_near;
using test::ring;
using test::Scanner;

const Pose2 kMount{0.14, 0.0, 0.0};

struct Recording {
  std::vector<SensorMessage> messages;
  std::vector<StampedPose2> truth;
};

/// One round and a third, 10 scans a second; odometry at 20 a second that is 2 % off and turns.
const Recording& recording() {
  static const Recording result = [] {
    Recording made;
    const auto poses = test::drive_through(
        {{1.5, 1.5}, {12.3, 1.6}, {12.4, 8.4}, {1.6, 8.5}, {1.5, 1.6}, {12.2, 1.5}}, 0.1, 0.12);
    const Scanner scanner{
        .angle_increment_rad = radians(1.0), .beams = 271, .range_max_m = 20.0, .noise_m = 0.01};
    Rng rng(5);
    Pose2 odometry;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const Stamp stamp{1'000'000'000 + static_cast<std::int64_t>(i) * 100'000'000};
      if (i > 0) {
        const Pose2 step = poses[i - 1].inverse() * poses[i];
        const Pose2 measured{1.02 * step.x, 0.0, step.yaw + 0.0005};
        made.messages.emplace_back(OdometryPose{stamp - Duration{50'000'000},
                                                interpolate(odometry, odometry * measured, 0.5)});
        odometry = odometry * measured;
      }
      made.messages.emplace_back(OdometryPose{stamp, odometry});
      auto scan = test::scan_from(ring(), poses[i], kMount, scanner, &rng);
      scan.stamp = stamp;
      made.messages.emplace_back(std::move(scan));
      made.truth.push_back({stamp, poses.front().inverse() * poses[i]});
    }
    return made;
  }();
  return result;
}

MapResult map_of(const std::vector<SensorMessage>& messages, int threads) {
  Mapper mapper({}, {}, {threads});
  for (const auto& message : messages) mapper.add(message);
  return mapper.finish();
}

const MapResult& mapped() {
  static const MapResult result = map_of(recording().messages, 1);
  return result;
}

double worst_error_m(const MapResult& result) {
  double worst = 0.0;
  for (const auto& truth : recording().truth) {
    const auto pose = result.trajectory.at(truth.stamp);
    if (!pose) return std::numeric_limits<double>::infinity();
    worst = std::max(worst, std::hypot(pose->x - truth.pose.x, pose->y - truth.pose.y));
  }
  return worst;
}

void expect_finite(const MapResult& result) {
  for (const auto& pose : result.trajectory.poses()) ASSERT_TRUE(pose.pose.vector().allFinite());
  for (const auto& pose : result.graph.poses) ASSERT_TRUE(pose.vector().allFinite());
}

TEST(Mapper, DrawsTheRingAndClosesIt) {
  const auto& result = mapped();
  EXPECT_LT(worst_error_m(result), 0.08);
  EXPECT_GE(result.statistics.loop_closures_accepted, 1);
  EXPECT_EQ(result.statistics.scans, static_cast<std::int64_t>(recording().truth.size()));
  EXPECT_EQ(result.statistics.scans_dropped, 0);
  EXPECT_EQ(result.trajectory.size(), recording().truth.size());
  EXPECT_EQ(result.odometry.size(), recording().truth.size());
  EXPECT_EQ(result.node_stamps.size(), result.graph.poses.size());
  EXPECT_EQ(result.statistics.key_scans - result.statistics.key_scans_thinned,
            static_cast<std::int64_t>(result.graph.poses.size()));
  EXPECT_NEAR(result.statistics.graph_cost, graph_cost(result.graph), 1e-9);
  EXPECT_NEAR(result.statistics.duration_s, 0.1 * static_cast<double>(recording().truth.size() - 1),
              1e-6);
  EXPECT_TRUE(result.complete);
  // Every node is the trajectory at its stamp.
  for (std::size_t i = 0; i < result.graph.poses.size(); ++i) {
    EXPECT_TRUE(
        pose_near(*result.trajectory.at(result.node_stamps[i]), result.graph.poses[i], 1e-9, 1e-9));
  }
}

TEST(Mapper, TheMapShowsWallsAndFloorWhereTheyAre) {
  const auto& map = mapped().map;
  const Pose2 map_T_world = Pose2{1.5, 1.5, recording().truth.front().pose.yaw}.inverse();
  const auto probability = [&](double x, double y) {
    const Cell cell = map.log_odds.frame().cell_of(map_T_world * Eigen::Vector2d(x, y));
    return map.log_odds.frame().contains(cell) ? map.probability(cell) : 0.5;
  };
  for (double x = 2.0; x < 12.0; x += 0.5)
    EXPECT_LT(probability(x, 1.5), 0.4) << "the floor at " << x;
  int walls = 0;
  int looked_at = 0;
  for (double x = 2.0; x < 12.0; x += 0.21, ++looked_at) {
    double most = 0.0;
    for (double y = -0.1; y < 0.11; y += 0.05) most = std::max(most, probability(x, y));
    if (most > 0.6) ++walls;
  }
  EXPECT_GT(walls, looked_at * 8 / 10);
  EXPECT_NEAR(probability(7.0, 5.0), 0.5, 0.01) << "inside the block nobody looked";
}

TEST(Mapper, OneAndManyThreadsGiveTheSameBytes) {
  const auto& one = mapped();
  const auto many = map_of(recording().messages, 4);
  ASSERT_EQ(one.trajectory.size(), many.trajectory.size());
  for (std::size_t i = 0; i < one.trajectory.size(); ++i) {
    ASSERT_EQ(one.trajectory.poses()[i].stamp, many.trajectory.poses()[i].stamp);
    ASSERT_EQ(one.trajectory.poses()[i].pose, many.trajectory.poses()[i].pose) << "scan " << i;
    ASSERT_EQ(one.odometry.poses()[i].pose, many.odometry.poses()[i].pose);
  }
  ASSERT_EQ(one.graph.edges.size(), many.graph.edges.size());
  EXPECT_EQ(one.graph.poses, many.graph.poses);
  ASSERT_EQ(one.verdict.measures.size(), many.verdict.measures.size());
  for (std::size_t i = 0; i < one.verdict.measures.size(); ++i) {
    EXPECT_EQ(one.verdict.measures[i].value, many.verdict.measures[i].value);
    EXPECT_EQ(one.verdict.measures[i].sentence, many.verdict.measures[i].sentence);
  }
  for (std::size_t i = 0; i < one.graph.edges.size(); ++i) {
    EXPECT_EQ(one.graph.edges[i].from_T_to, many.graph.edges[i].from_T_to);
    EXPECT_EQ(one.graph.edges[i].information, many.graph.edges[i].information);
  }
  ASSERT_EQ(one.loop_closures.size(), many.loop_closures.size());
  for (std::size_t i = 0; i < one.loop_closures.size(); ++i) {
    EXPECT_EQ(one.loop_closures[i].from_T_to, many.loop_closures[i].from_T_to);
    EXPECT_EQ(one.loop_closures[i].score, many.loop_closures[i].score);
    EXPECT_EQ(one.loop_closures[i].reason, many.loop_closures[i].reason);
  }
  EXPECT_EQ(one.map.log_odds.frame(), many.map.log_odds.frame());
  EXPECT_EQ(one.map.log_odds.cells(), many.map.log_odds.cells());
  EXPECT_EQ(one.map.observed.cells(), many.map.observed.cells());
}

TEST(Mapper, JudgesItsMap) {
  const MapResult& result = mapped();
  EXPECT_EQ(result.verdict.overall, Verdict::kGood) << result.verdict.sentence;
  EXPECT_GT(result.quality.walls_compared, 1000) << "the last third was driven twice";
  EXPECT_LT(result.quality.wall_offset_m, 0.02);
  EXPECT_GT(result.graph_quality.loops, 0);
  ASSERT_TRUE(result.graph_quality.certificate.has_value());
  EXPECT_TRUE(result.graph_quality.certificate->certified());
}

TEST(Mapper, NothingInNothingOut) {
  for (const int threads : {1, 3}) {
    Mapper mapper({}, {}, {threads});
    const auto result = mapper.finish();
    EXPECT_TRUE(result.trajectory.empty());
    EXPECT_TRUE(result.graph.poses.empty());
    EXPECT_TRUE(result.loop_closures.empty());
    EXPECT_EQ(result.statistics.scans, 0);
    EXPECT_EQ(result.statistics.path_length_m, 0.0);
    EXPECT_EQ(result.verdict.overall, Verdict::kUnknown);
  }
  Mapper unfinished({}, {}, {2});  // may go without finish()
  for (std::size_t i = 0; i < 30; ++i) unfinished.add(recording().messages[i]);
}

TEST(Mapper, OdometryAloneMakesNoMap) {
  Mapper mapper({}, {}, {1});
  for (const auto& message : recording().messages) {
    if (std::holds_alternative<OdometryPose>(message)) mapper.add(message);
  }
  EXPECT_TRUE(mapper.finish().trajectory.empty());
}

TEST(Mapper, WorksWithoutOdometry) {
  std::vector<SensorMessage> scans;
  for (const auto& message : recording().messages) {
    if (std::holds_alternative<LaserScan>(message)) scans.push_back(message);
  }
  const auto result = map_of(scans, 2);
  EXPECT_LT(worst_error_m(result), 0.08);
  EXPECT_TRUE(result.odometry.empty());
}

TEST(Mapper, ScansThatSawNothingAreCountedAndKeepTheirPose) {
  std::vector<SensorMessage> messages;
  for (std::size_t i = 0; i < 90; ++i) {
    auto message = recording().messages[i];
    if (auto* scan = std::get_if<LaserScan>(&message)) {
      // no returns, bad beams, no beams at all
      const float fill = i % 2 == 0 ? std::numeric_limits<float>::infinity()
                                    : std::numeric_limits<float>::quiet_NaN();
      scan->ranges_m.assign(i % 3 == 0 ? 0U : scan->ranges_m.size(), fill);
    }
    messages.push_back(std::move(message));
  }
  const auto result = map_of(messages, 2);
  EXPECT_GT(result.statistics.scans, 20);
  EXPECT_EQ(result.statistics.scans_dropped, result.statistics.scans);
  EXPECT_EQ(result.statistics.key_scans, 0);
  EXPECT_EQ(result.trajectory.size(), static_cast<std::size_t>(result.statistics.scans));
  expect_finite(result);
  // Dead reckoning is all there is.
  EXPECT_NEAR(result.trajectory.back().pose.x,
              result.odometry.back().pose.x - result.odometry.front().pose.x, 1e-6);
}

TEST(Mapper, BlindStretchesAreBridgedByOdometry) {
  auto messages = recording().messages;
  for (std::size_t i = 100; i < 160; ++i) {
    if (auto* scan = std::get_if<LaserScan>(&messages[i])) {
      scan->ranges_m.assign(scan->ranges_m.size(), std::numeric_limits<float>::infinity());
    }
  }
  const auto result = map_of(messages, 1);
  EXPECT_GT(result.statistics.scans_dropped, 15);
  EXPECT_LT(worst_error_m(result), 0.15);
}

TEST(Mapper, WhatOdometryAloneCarriesToTheEndOfTheLogIsUncertainAndSaidSo) {
  auto messages = recording().messages;
  for (std::size_t i = messages.size() / 3; i < messages.size(); ++i) {
    if (auto* scan = std::get_if<LaserScan>(&messages[i])) {
      scan->ranges_m.assign(scan->ranges_m.size(), std::numeric_limits<float>::infinity());
    }
  }
  const auto result = map_of(messages, 1);
  ASSERT_FALSE(result.breaks.empty());
  const PathBreak& open_end = result.breaks.back();
  EXPECT_TRUE(open_end.ends_log);
  EXPECT_EQ(open_end.bridge, BreakBridge::kOdometry);
  EXPECT_EQ(open_end.to, result.trajectory.back().stamp);
  EXPECT_EQ(open_end.to_scan, result.trajectory.size());
  const auto sigma_m = [&](Stamp stamp) { return std::sqrt(result.covariance_at(stamp)(0, 0)); };
  EXPECT_LT(sigma_m(open_end.from), 0.1);
  const Stamp between = open_end.from + Duration{(open_end.to - open_end.from).nanoseconds / 2};
  EXPECT_GT(sigma_m(between), 2.0 * sigma_m(open_end.from));
  EXPECT_GT(sigma_m(open_end.to), 1.5 * sigma_m(between));
  const Pose2& truth = recording().truth.back().pose;
  const Pose2 last = result.trajectory.back().pose;
  EXPECT_LT(std::hypot(last.x - truth.x, last.y - truth.y), 3.0 * sigma_m(open_end.to));
  EXPECT_NE(result.verdict.overall, Verdict::kGood);
  EXPECT_TRUE(std::ranges::any_of(result.warnings, [](const std::string& warning) {
    return warning.find("to the end") != warning.npos;
  })) << "nobody was told";

  const auto whole = map_of(recording().messages, 1);
  EXPECT_TRUE(std::ranges::none_of(whole.breaks, &PathBreak::ends_log));
}

TEST(Mapper, RepeatedAndReversedStampsDoNoHarm) {
  std::vector<SensorMessage> messages;
  for (std::size_t i = 0; i < 300; ++i) {
    auto message = recording().messages[i];
    if (auto* scan = std::get_if<LaserScan>(&message)) {
      if (i % 4 == 0) messages.push_back(message);  // twice
      if (i % 7 == 0) scan->stamp = scan->stamp - Duration{300'000'000};
      if (i % 11 == 0) scan->stamp = scan->stamp + Duration{100'000'000};
    }
    messages.push_back(std::move(message));
  }
  const auto result = map_of(messages, 1);
  expect_finite(result);
  EXPECT_GT(result.trajectory.size(), 50U);
}

TEST(Mapper, ScansOfASweepThatComeInABurstAreNotBentByTheirStamps) {
  // The ring lies within 14 m x 10 m; the robot turns at its corners.
  std::vector<SensorMessage> messages = recording().messages;
  int scans = 0;
  for (SensorMessage& message : messages) {
    auto* scan = std::get_if<LaserScan>(&message);
    if (scan == nullptr) continue;
    scan->time_increment_s = 0.06 / static_cast<double>(scan->ranges_m.size());
    // Each tenth is stamped 98 ms late: 2 ms before the next one.
    if (++scans % 10 == 0) scan->stamp = scan->stamp + Duration{98'000'000};
  }
  const MapResult burst = map_of(messages, 1);
  const GridFrame& frame = burst.map.log_odds.frame();
  const GridFrame& usual = mapped().map.log_odds.frame();
  EXPECT_LT(frame.columns, usual.columns + 40) << "cells of 5 cm";
  EXPECT_LT(frame.rows, usual.rows + 40);
}

TEST(Mapper, StandingStillMakesOneKeyScan) {
  std::vector<SensorMessage> messages;
  auto scan = std::get<LaserScan>(recording().messages[1]);
  for (int i = 0; i < 50; ++i) {
    scan.stamp = scan.stamp + Duration{100'000'000};
    messages.emplace_back(OdometryPose{scan.stamp, Pose2{}});
    messages.emplace_back(scan);
  }
  const auto result = map_of(messages, 1);
  EXPECT_EQ(result.statistics.scans, 50);
  EXPECT_EQ(result.statistics.key_scans, 1);
  EXPECT_LT(result.statistics.path_length_m, 0.01);
}

TEST(Mapper, ALogWithoutLoopClosureHasAChainOfEdges) {
  MapOptions options;
  options.loop_closure = false;
  options.adjustment.enabled = false;  // it leaves the graph's own optimum
  Mapper mapper({}, options, {1});
  for (std::size_t i = 0; i < 300; ++i) mapper.add(recording().messages[i]);
  const auto result = mapper.finish();
  EXPECT_TRUE(result.loop_closures.empty());
  ASSERT_EQ(result.graph.edges.size() + 1, result.graph.poses.size());
  EXPECT_NEAR(result.statistics.graph_cost, 0.0, 1e-12);
}

TEST(Mapper, InterruptedAtItsEndItLeavesTheMapUnjudgedAndSaysSo) {
  Mapper mapper({}, {}, {1});
  for (std::size_t i = 0; i < 60; ++i) mapper.add(recording().messages[i]);
  const MapResult result = mapper.finish([](const Progress&) { return false; });
  EXPECT_FALSE(result.complete);
  EXPECT_FALSE(result.trajectory.empty());
  EXPECT_FALSE(result.map.log_odds.empty());
  EXPECT_TRUE(result.verdict.measures.empty());
}

}  // namespace
}  // namespace loopstone
