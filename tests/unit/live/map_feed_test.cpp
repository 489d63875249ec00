#include "loopstone/live/map_feed.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "live/tile_store.hpp"
#include "loopstone/slam/live_map.hpp"
#include "support/simulated_log.hpp"
#include "unit/live/recorded_view.hpp"

namespace loopstone {
namespace {

using test::RecordedView;
using test::SeenNodes;
using test::SeenTiles;

constexpr ViewPeriods kAlways{
    .robot_s = 0.0, .status_s = 0.0, .map_s = 0.0, .closures_s = 0.0, .standard_s = 0.0};

/// An office, twice round, seen by who looks on all the time.
class Feed : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    log_ = new test::SimulatedLog(test::simulate_log("rooms", 1, {.duration_s = 40.0}));
  }
  static void TearDownTestSuite() {
    delete log_;
    log_ = nullptr;
  }

  struct Run {
    MapResult result{};
    MapSnapshot last{};
  };
  Run map(MapFeed& feed) const {
    Mapper mapper(log_->robot, MapOptions{}, Threads{2});
    for (const SensorMessage& message : log_->messages) {
      feed.add(message);
      mapper.add(message);
      while (const auto update = mapper.next_update()) feed.add(*update, mapper);
    }
    (void)mapper.judge_robot();
    feed.end(mapper);
    feed.flush();
    Run run{.last = mapper.snapshot()};
    live_tiles_ = tiles();
    run.result = mapper.finish();
    feed.finish(run.result);
    return run;
  }
  [[nodiscard]] SeenTiles tiles() const {
    SeenTiles seen;
    for (const auto& message : view_.all("/loopstone/tiles"))
      seen.take(view_.decoded<msg::MapTiles>("/loopstone/tiles", message.bytes));
    return seen;
  }
  [[nodiscard]] SeenNodes nodes() const {
    SeenNodes seen;
    for (const auto& message : view_.all("/loopstone/trajectory"))
      seen.take(view_.decoded<msg::Trajectory>("/loopstone/trajectory", message.bytes));
    return seen;
  }

  static inline test::SimulatedLog* log_ = nullptr;
  RecordedView view_{};
  ViewBoard board_{view_.sink()};
  mutable SeenTiles live_tiles_{};
};

TEST_F(Feed, OfMoreWarningsThanAnybodyReadsTheOldestAreCounted) {
  MapFeed feed(board_, log_->robot, {});
  for (int i = 0; i < 250; ++i) feed.add_warning("trouble " + std::to_string(i));
  const auto warnings = view_.last_json("/loopstone/warnings")["warnings"];
  ASSERT_EQ(warnings.size(), 201U);
  EXPECT_EQ(warnings[0]["text"], "50 earlier ones");
  EXPECT_EQ(warnings[1]["text"], "trouble 50");
  EXPECT_EQ(warnings[200]["text"], "trouble 249");
}

TEST_F(Feed, ShowsWhatTheMapperDoes) {
  MapFeed feed(board_, log_->robot, {}, kAlways);
  const Run run = map(feed);
  const MapResult& result = run.result;
  const auto scans = log_->scans();

  // Every scan, with the pose of its own time.
  EXPECT_GE(view_.all("/tf").size(), scans.size());
  EXPECT_GE(view_.all("/scan").size(), scans.size());
  for (const auto& message : view_.all("/pose")) {
    const auto pose = view_.decoded<msg::PoseWithCovarianceStamped>("/pose", message.bytes);
    EXPECT_EQ(pose.header.stamp, message.stamp);
  }
  // The path, in the end as it was delivered.
  const SeenNodes seen = nodes();
  ASSERT_EQ(seen.t.size(), result.node_stamps.size());
  for (std::size_t i = 0; i < seen.t.size(); ++i) {
    const Pose2 pose = result.trajectory.at_clamped(result.node_stamps[i]).value();
    EXPECT_NEAR(seen.poses[3 * i], pose.x, 2e-3);
    EXPECT_NEAR(seen.poses[3 * i + 1], pose.y, 2e-3);
    EXPECT_TRUE(std::isfinite(seen.sigma[i]));
  }
  EXPECT_GT(*std::ranges::max_element(seen.sigma), 0.0F);
  EXPECT_EQ(view_.last<msg::Path>("/path").poses.size(), result.trajectory.size());

  const auto status = view_.last_json("/loopstone/status");
  EXPECT_EQ(status["scans"], scans.size());
  EXPECT_EQ(status["closures"], result.statistics.loop_closures_accepted);
  EXPECT_NEAR(status["travelled_m"].get<double>(), result.statistics.path_length_m,
              0.2 * result.statistics.path_length_m + 0.5);
  EXPECT_GT(status["figures"].size(), 1U);
  const auto closures = view_.list("closures");
  ASSERT_EQ(closures.size(), result.loop_closures.size());
  for (std::size_t i = 0; i < closures.size(); ++i) {
    const LoopClosure& closure = result.loop_closures[i];
    EXPECT_EQ(closures[i]["state"], to_string(closure.state));
    EXPECT_EQ(closures[i]["from"], closure.from.index);
    EXPECT_EQ(closures[i]["score"], closure.score);
  }
  const auto submaps = view_.list("submaps");
  EXPECT_EQ(submaps.size(), run.last.submaps.size());
  for (const auto& submap : submaps) EXPECT_GE(submap["outline"].size(), 6U);
  const auto verdict = view_.last_json("/loopstone/verdict");
  EXPECT_EQ(verdict["sentence"], result.verdict.sentence);
  EXPECT_EQ(verdict["complete"], true);
  EXPECT_FALSE(view_.last<msg::MarkerArray>("/graph").markers.empty());
}

TEST_F(Feed, TilesAreTheMap) {
  MapFeed feed(board_, log_->robot, {}, kAlways);
  const Run run = map(feed);
  // In the end the delivered one, cell for cell.
  const SeenTiles seen = tiles();
  const GridFrame& frame = run.result.map.observed.frame();
  std::size_t known = 0;
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      const Cell cell{column, row};
      const Eigen::Vector2d centre = frame.centre_of(cell);
      const int percent = seen.at(centre.x(), centre.y(), frame.resolution);
      if (run.result.map.observed[cell] == 0) {
        EXPECT_EQ(percent, 255);
        continue;
      }
      ++known;
      EXPECT_NEAR(percent, 100.0 * run.result.map.probability(cell), 0.51);
    }
  }
  EXPECT_NEAR(board_.known_area_m2(),
              static_cast<double>(known) * frame.resolution * frame.resolution, 1e-6);
  // And before, what a live map has of the same snapshot.
  LiveMap live({}, log_->robot.footprint_radius_m);
  live.refresh(run.last, LiveMap::kNoLimit);
  TileStore store;
  store.clear(live.resolution_m());
  (void)store.change(live.tiles_since(0));
  SeenTiles expected;
  expected.take(store.whole());
  EXPECT_EQ(live_tiles_.tiles().size(), expected.tiles().size());
  EXPECT_EQ(live_tiles_.tiles(), expected.tiles());
}

TEST_F(Feed, WhoComesLateGetsAllOfIt) {
  MapFeed feed(board_, log_->robot, {}, kAlways);
  (void)map(feed);
  SeenTiles late;
  late.take(view_.decoded<msg::MapTiles>("/loopstone/tiles",
                                         view_.channel("/loopstone/tiles").whole().value().bytes));
  EXPECT_EQ(late.tiles(), tiles().tiles());
  SeenNodes late_nodes;
  late_nodes.take(view_.decoded<msg::Trajectory>(
      "/loopstone/trajectory", view_.channel("/loopstone/trajectory").whole().value().bytes));
  EXPECT_EQ(late_nodes.poses, nodes().poses);
  for (const std::string name : {"closures", "submaps"}) {
    const ViewMessage whole = view_.channel("/loopstone/" + name).whole().value();
    test::SeenList late_list;
    late_list.take(nlohmann::json::parse(whole.bytes), name);
    EXPECT_EQ(late_list.entries(), view_.list(name)) << name;
  }
}

TEST_F(Feed, WhatOnlyOtherProgramsReadIsDrawnWhenSomebodyTakesIt) {
  view_.set_unwanted({"/map", "/path", "/graph"});
  MapFeed feed(board_, log_->robot, {}, kAlways);
  Mapper mapper(log_->robot, MapOptions{}, Threads{1});
  for (const SensorMessage& message : log_->messages) {
    feed.add(message);
    mapper.add(message);
    while (const auto update = mapper.next_update()) feed.add(*update, mapper);
  }
  feed.end(mapper);
  feed.flush();
  EXPECT_FALSE(view_.list("submaps").empty());
  for (const char* topic : {"/map", "/path", "/graph"}) EXPECT_TRUE(view_.all(topic).empty());
  // Nothing more happens, but somebody comes.
  view_.set_unwanted({"/map", "/path"});
  for (int i = 0; i < 2000 && view_.all("/graph").empty(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_FALSE(view_.all("/graph").empty());
}

TEST_F(Feed, TheResultIsTheSameWhoeverLooksOn) {
  MapFeed feed(board_, log_->robot, {}, kAlways);
  const MapResult seen = map(feed).result;
  Mapper mapper(log_->robot, MapOptions{}, Threads{2});
  for (const SensorMessage& message : log_->messages) mapper.add(message);
  (void)mapper.judge_robot();
  const MapResult alone = mapper.finish();
  ASSERT_EQ(seen.trajectory.size(), alone.trajectory.size());
  for (std::size_t i = 0; i < seen.trajectory.size(); ++i)
    EXPECT_EQ(seen.trajectory.poses()[i].pose, alone.trajectory.poses()[i].pose);
  EXPECT_EQ(seen.map.log_odds.cells(), alone.map.log_odds.cells());
}

TEST_F(Feed, HoldsBackWhatComesTooSoonAndCatchesUp) {
  MapFeed feed(board_, log_->robot, {}, {.robot_s = 3600.0, .status_s = 3600.0, .map_s = 3600.0});
  Mapper mapper(log_->robot, MapOptions{}, Threads{1});
  for (const SensorMessage& message : log_->messages) {
    feed.add(message);
    mapper.add(message);
    while (const auto update = mapper.next_update()) feed.add(*update, mapper);
  }
  EXPECT_EQ(view_.all("/tf").size(), 1U);
  EXPECT_EQ(view_.all("/loopstone/status").size(), 1U);
  feed.catch_up(mapper);
  EXPECT_EQ(view_.all("/tf").size(), 1U);  // not yet
  RecordedView other;
  ViewBoard other_board(other.sink());
  MapFeed quick(other_board, log_->robot, {}, {.robot_s = 1e-3});
  Mapper again(log_->robot, MapOptions{}, Threads{1});
  Stamp last{};
  for (const SensorMessage& message : log_->messages) {
    quick.add(message);
    again.add(message);
    while (const auto update = again.next_update()) {
      quick.add(*update, again);
      last = update->stamp;
    }
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(5));
  quick.catch_up(again);
  EXPECT_EQ(other.all("/tf").back().stamp, last);
}

TEST_F(Feed, BeginsAnew) {
  MapFeed feed(board_, log_->robot, {}, kAlways);
  (void)map(feed);
  feed.begin_anew(log_->robot);
  EXPECT_TRUE(tiles().tiles().empty());
  EXPECT_TRUE(nodes().t.empty());
  EXPECT_TRUE(view_.list("closures").empty());
  EXPECT_TRUE(view_.list("submaps").empty());
  const MapResult again = map(feed).result;
  EXPECT_EQ(nodes().t.size(), again.node_stamps.size());
  EXPECT_EQ(view_.last_json("/loopstone/status")["scans"], log_->scans().size());
}

TEST_F(Feed, EndsInTheMidst) {
  MapFeed feed(board_, log_->robot, {}, kAlways);
  Mapper mapper(log_->robot, MapOptions{}, Threads{1});
  for (std::size_t i = 0; i < log_->messages.size() / 3; ++i) {
    feed.add(log_->messages[i]);
    mapper.add(log_->messages[i]);
    while (const auto update = mapper.next_update()) feed.add(*update, mapper);
  }
}

}  // namespace
}  // namespace loopstone
