#include "loopstone/live/view_board.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "live/hull.hpp"
#include "live/node_track.hpp"
#include "live/tile_store.hpp"
#include "unit/live/recorded_view.hpp"

namespace loopstone {
namespace {

using test::RecordedView;
using test::SeenNodes;
using test::SeenTiles;
using testing::ElementsAre;

constexpr Stamp kNow{5'000'000'000};

TEST(ViewBoard, HasTheChannelsOfTheContract) {
  RecordedView view;
  const ViewBoard board(view.sink());
  std::set<std::string> topics;
  for (const ViewChannel& channel : view.channels()) {
    topics.insert(channel.topic);
    EXPECT_EQ(channel.whole != nullptr, channel.policy == SendPolicy::kChanges) << channel.topic;
    if (channel.encoding == "cdr") {
      EXPECT_EQ(channel.schema_encoding, "ros2msg");
      continue;
    }
    EXPECT_EQ(channel.encoding, "json");
    EXPECT_EQ(channel.schema_encoding, "jsonschema");
    const auto schema = nlohmann::json::parse(channel.schema);
    EXPECT_EQ(schema["type"], "object") << channel.topic;
    EXPECT_FALSE(schema["properties"].empty()) << channel.topic;
  }
  EXPECT_EQ(topics, (std::set<std::string>{
                        "/tf", "/tf_static", "/scan", "/pose", "/map", "/path", "/graph",
                        "/loopstone/tiles", "/loopstone/trajectory", "/loopstone/status",
                        "/loopstone/closures", "/loopstone/submaps", "/loopstone/verdict",
                        "/loopstone/warnings", "/loopstone/quality", "/loopstone/texture"}));
  EXPECT_EQ(view.channel("/scan").policy, SendPolicy::kDroppable);
  EXPECT_EQ(view.channel("/loopstone/closures").policy, SendPolicy::kChanges);
}

TEST(ViewBoard, ShowsTheRobotAndItsScan) {
  RecordedView view;
  ViewBoard board(view.sink());
  RobotModel robot;
  robot.lidars.at(0).robot_T_lidar = {0.2, 0.1, 0.5};
  LaserScan scan{.stamp = kNow,
                 .angle_min_rad = -1.0,
                 .angle_increment_rad = 0.5,
                 .range_min_m = 0.1,
                 .range_max_m = 9.0,
                 .ranges_m = {1.0F, 2.0F, 3.0F}};
  Eigen::Matrix3d covariance;
  covariance << 1, 2, 3, 2, 5, 6, 3, 6, 9;
  board.show_robot(kNow, {1.0, 2.0, 0.5}, covariance, &scan, robot);
  board.show_robot(kNow, {1.0, 2.0, 0.5}, covariance, &scan, robot);
  EXPECT_EQ(view.now(), kNow);
  const auto tf = view.last<msg::TFMessage>("/tf");
  ASSERT_EQ(tf.transforms.size(), 1U);
  EXPECT_EQ(tf.transforms[0].header.frame_id, "map");
  EXPECT_EQ(tf.transforms[0].child_frame_id, "base_link");
  EXPECT_EQ(tf.transforms[0].transform.translation.y, 2.0);
  EXPECT_EQ(view.all("/tf_static").size(), 1U);  // nothing new the second time
  EXPECT_EQ(view.last<msg::TFMessage>("/tf_static").transforms[0].child_frame_id, "laser");
  const auto seen = view.last<msg::LaserScan>("/scan");
  EXPECT_EQ(seen.header.frame_id, "laser");
  EXPECT_THAT(seen.ranges, ElementsAre(1.0F, 2.0F, 3.0F));
  const auto pose = view.last<msg::PoseWithCovarianceStamped>("/pose");
  EXPECT_EQ(pose.pose.covariance[0], 1.0);
  EXPECT_EQ(pose.pose.covariance[1], 2.0);
  EXPECT_EQ(pose.pose.covariance[5], 3.0);
  EXPECT_EQ(pose.pose.covariance[11], 6.0);
  EXPECT_EQ(pose.pose.covariance[35], 9.0);
  // Another laser has a topic and a frame of its own.
  scan.lidar = 1;
  robot.lidars.push_back(robot.lidars[0]);
  board.show_robot(kNow, {}, covariance, &scan, robot);
  EXPECT_EQ(view.last<msg::LaserScan>("/scan_2").header.frame_id, "laser_2");
  EXPECT_EQ(view.last<msg::TFMessage>("/tf_static").transforms.size(), 2U);
}

TEST(ViewBoard, AStampThatRosHasNoPlaceForIsLeftOut) {
  RecordedView view;
  ViewBoard board(view.sink());
  board.show_robot(Stamp{std::int64_t{1} << 62}, {}, Eigen::Matrix3d::Zero(), nullptr, {});
  board.show_path(Stamp{std::int64_t{1} << 62}, {});
  EXPECT_TRUE(view.all("/tf").empty());
  EXPECT_TRUE(view.all("/path").empty());
}

TEST(ViewBoard, TellsClosuresWhenTheyChange) {
  RecordedView view;
  ViewBoard board(view.sink());
  ViewClosure one{.from_node = 3, .to_node = 9, .from = Stamp{1'000'000'000}, .to = kNow};
  one.closure.state = ClosureState::kStanding;
  one.closure.covariance = Eigen::Vector3d(0.04, 0.01, 0.1).asDiagonal();
  one.closure.second_score = 0.25;
  board.show_closures(kNow, {one});
  board.show_closures(kNow, {one});
  EXPECT_EQ(view.all("/loopstone/closures").size(), 1U);
  const auto told = view.list("closures");
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0]["id"], 0);
  EXPECT_EQ(told[0]["from"], 3);
  EXPECT_EQ(told[0]["to_t"], 5.0);
  EXPECT_EQ(told[0]["state"], "standing");
  EXPECT_EQ(told[0]["second_score"], 0.25);
  EXPECT_TRUE(told[0]["chi2"].is_null());
  EXPECT_NEAR(told[0]["sigma_m"].get<double>(), 0.2, 1e-12);
}

TEST(ViewBoard, OfListsOnlyWhatChangedIsTold) {
  RecordedView view;
  ViewBoard board(view.sink());
  std::vector<ViewClosure> closures(100);
  for (ViewClosure& one : closures) one.closure.chi2 = 1.0;
  board.show_closures(kNow, closures);
  // Another solution moves every chi-square a little, and one a lot.
  for (ViewClosure& one : closures) one.closure.chi2 = 1.01;
  closures[7].closure.chi2 = 50.0;
  closures[9].closure.state = ClosureState::kRevoked;
  closures.emplace_back();
  board.show_closures(kNow, closures);
  const auto changes = view.last_json("/loopstone/closures");
  EXPECT_EQ(changes["count"], 101);
  std::vector<int> ids;
  for (const auto& one : changes["closures"]) ids.push_back(one["id"]);
  EXPECT_THAT(ids, ElementsAre(7, 9, 100));
  // Steps that are small one by one are told once they add up.
  for (int i = 2; i <= 40; ++i) {
    for (ViewClosure& one : closures) one.closure.chi2 = 1.0 + 0.01 * i;
    board.show_closures(kNow, closures);
  }
  EXPECT_NEAR(view.list("closures")[3]["chi2"].get<double>(), 1.4, 0.25);
  closures.resize(3);
  board.show_closures(kNow, closures);
  EXPECT_EQ(view.list("closures").size(), 3U);

  std::vector<ViewSubmap> submaps(3);
  for (std::size_t i = 0; i < submaps.size(); ++i)
    submaps[i] = {.id = i, .outline = {{0, 0}, {1, 0}, {0, 1}}};
  board.show_submaps(kNow, submaps);
  submaps[0].map_T_submap.x = 1e-4;
  submaps[1].map_T_submap.x = 0.1;
  submaps[2].outline.emplace_back(-1, -1);
  board.show_submaps(kNow, submaps);
  EXPECT_EQ(view.last_json("/loopstone/submaps")["submaps"].size(), 2U);
  EXPECT_EQ(view.list("submaps")[1]["pose"][0], 0.1);
  EXPECT_EQ(view.list("submaps")[2]["outline"].size(), 8U);
}

TEST(ViewBoard, AnswersForTheEvidenceOfAClosure) {
  RecordedView view;
  ViewBoard board(view.sink());
  const auto scan_ahead = [](float range_m) {
    return std::make_shared<const MappedScan>(MappedScan{
        .scan = {.range_max_m = 9.0, .ranges_m = {range_m}}, .robot_T_lidar = {0.5, 0, 0}});
  };
  ViewClosure one{
      .from_T_to = {3, 2, 1}, .from_scan = scan_ahead(1.0F), .to_scan = scan_ahead(2.0F)};
  one.closure.from_T_to = {1, 2, 0.5};
  board.show_closures(kNow, {ViewClosure{}, one});
  const auto answer = board.answer("/api/closures/1");
  ASSERT_TRUE(answer.has_value());
  const auto json = nlohmann::json::parse(answer->body);
  EXPECT_EQ(json["id"], 1);
  EXPECT_EQ(json["from"]["points"], (nlohmann::json{1.5, 0.0}));
  EXPECT_EQ(json["to"]["points"], (nlohmann::json{2.5, 0.0}));
  EXPECT_EQ(json["measured"], (nlohmann::json{1.0, 2.0, 0.5}));
  EXPECT_EQ(json["graph"], (nlohmann::json{3.0, 2.0, 1.0}));
  EXPECT_TRUE(nlohmann::json::parse(board.answer("/api/closures/0")->body)["to"]["points"].empty());
  EXPECT_EQ(board.answer("/api/closures/2")->status, 404);
  for (const char* path : {"/api/closures/", "/api/closures/-1", "/api/closures/1x",
                           "/api/closures/99999999999999999999999", "/api/other"})
    EXPECT_FALSE(board.answer(path).has_value()) << path;
}

TEST(ViewBoard, NumbersThatAreNoneBecomeNull) {
  RecordedView view;
  ViewBoard board(view.sink());
  ViewStatus status{.stamp = kNow, .status = "tracked"};
  status.realtime = std::numeric_limits<double>::infinity();
  status.figures["sigma_m"] = std::numeric_limits<double>::quiet_NaN();
  board.show_status(status);
  EXPECT_TRUE(view.last_json("/loopstone/status")["realtime"].is_null());
  EXPECT_TRUE(view.last_json("/loopstone/status")["figures"]["sigma_m"].is_null());
  board.show_warnings(kNow, {{std::nullopt, "no UTF-8: \xff"}, {kNow, "later"}});
  const auto warnings = view.last_json("/loopstone/warnings")["warnings"];
  EXPECT_TRUE(warnings[0]["t"].is_null());
  EXPECT_EQ(warnings[1]["t"], 5.0);
}

TEST(ViewBoard, BeginsAnew) {
  RecordedView view;
  ViewBoard board(view.sink());
  CellStates cells({.origin = {0, 0}, .resolution = 0.1, .columns = 2, .rows = 1}, kOccupiedCell);
  board.replace_tiles(kNow, cells);
  board.show_nodes(kNow, {ViewNode{}});
  board.show_closures(kNow, {ViewClosure{}});
  board.show_quality(kNow, {.resolution_m = 0.5, .png = "PNG"});
  EXPECT_EQ(view.last_json("/loopstone/quality")["png"], "UE5H");
  board.begin_anew(kNow, 0.05);
  const auto tiles = view.last<msg::MapTiles>("/loopstone/tiles");
  EXPECT_TRUE(tiles.whole);
  EXPECT_TRUE(tiles.ids.empty());
  EXPECT_EQ(view.last<msg::Trajectory>("/loopstone/trajectory").count, 0U);
  EXPECT_TRUE(view.list("closures").empty());
  EXPECT_EQ(view.last_json("/loopstone/quality")["png"], "");
  EXPECT_FALSE(board.answer("/api/closures/0").value().status == 200);
}

TEST(TileStore, PutsCellsWhereTheyAre) {
  // Left of and below the origin, too, and over the edge of a tile.
  const GridFrame frame{.origin = {-0.2, 6.3}, .resolution = 0.1, .columns = 4, .rows = 3};
  CellStates cells(frame, kUnknownCell);
  cells[{0, 0}] = kOccupiedCell;  // x -0.2..-0.1, y 6.3..6.4: the last row of its tile
  cells[{3, 2}] = kFreeCell;
  TileStore store;
  store.replace(cells);
  SeenTiles seen;
  seen.take(store.whole());
  EXPECT_EQ(seen.at(-0.15, 6.35, 0.1), 100);
  EXPECT_EQ(seen.at(0.15, 6.55, 0.1), 0);
  EXPECT_EQ(seen.at(-0.05, 6.35, 0.1), 255);
  EXPECT_EQ(seen.tiles().size(), 2U);
  EXPECT_TRUE(seen.tiles().contains({-1, 0}));
  EXPECT_TRUE(seen.tiles().contains({0, 1}));
  EXPECT_NEAR(store.known_m2(), 0.02, 1e-12);
}

TEST(TileStore, TellsOnlyWhatChanged) {
  TileStore store;
  store.clear(0.1);
  OccupancyTile tile{.id = {2, -3}};
  tile.observed[7] = 1;
  tile.log_odds[7] = 2.0F;
  const auto first = store.change(std::vector{tile});
  EXPECT_THAT(first.ids, ElementsAre(2, -3));
  EXPECT_EQ(first.cells[7], 88);
  EXPECT_EQ(first.cells[8], 255);
  EXPECT_FALSE(first.whole);
  EXPECT_TRUE(store.change(std::vector{tile}).ids.empty());
  tile.observed[8] = 1;
  EXPECT_EQ(store.change(std::vector{tile}).cells[8], 50);
  EXPECT_NEAR(store.known_m2(), 0.02, 1e-12);
}

TEST(NodeTrack, TellsFromTheFirstDifferenceOn) {
  std::vector<ViewNode> nodes(5);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    nodes[i] = {.stamp = Stamp::from_seconds(static_cast<double>(i)),
                .map_T_robot = {static_cast<double>(i), 0, 0}};
  NodeTrack track;
  SeenNodes seen;
  seen.take(track.change({nodes.begin(), nodes.begin() + 3}).value());
  EXPECT_FALSE(track.change({nodes.begin(), nodes.begin() + 3}).has_value());
  const auto tail = track.change(nodes).value();
  EXPECT_EQ(tail.first, 3U);
  EXPECT_EQ(tail.count, 5U);
  seen.take(tail);
  nodes[1].map_T_robot.y = 0.5;
  nodes.pop_back();
  const auto moved = track.change(nodes).value();
  EXPECT_EQ(moved.first, 1U);
  EXPECT_EQ(moved.count, 4U);
  seen.take(moved);
  EXPECT_THAT(seen.t, ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(seen.poses[4], 0.5F);
  nodes.pop_back();
  EXPECT_EQ(track.change(nodes)->count, 3U);  // fewer, and nothing else
}

TEST(NodeTrack, ManySmallStepsAreSeen) {
  std::vector<ViewNode> nodes(1);
  NodeTrack track;
  SeenNodes seen;
  seen.take(track.change(nodes).value());
  for (int i = 0; i < 100; ++i) {
    nodes[0].map_T_robot.x += 0.0004;
    if (const auto change = track.change(nodes)) seen.take(*change);
  }
  EXPECT_NEAR(seen.poses[0], 0.04F, 0.0011F);
}

TEST(Hull, GoesRoundAllPoints) {
  EXPECT_TRUE(convex_hull({}).empty());
  EXPECT_EQ(convex_hull({{1, 1}, {1, 1}}).size(), 1U);
  EXPECT_EQ(convex_hull({{0, 0}, {1, 1}, {2, 2}}).size(), 2U);
  const auto hull = convex_hull({{0, 0}, {2, 0}, {1, 1}, {2, 2}, {0, 2}, {1, 0}, {0.5, 1.5}});
  EXPECT_THAT(hull, ElementsAre(Eigen::Vector2f(0, 0), Eigen::Vector2f(2, 0), Eigen::Vector2f(2, 2),
                                Eigen::Vector2f(0, 2)));
}

}  // namespace
}  // namespace loopstone
