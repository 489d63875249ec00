#include "loopstone/live/folder_view.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "unit/live/recorded_view.hpp"

namespace loopstone {
namespace {

using Json = nlohmann::json;
using test::RecordedView;
using testing::ElementsAre;

constexpr Stamp at(int seconds) { return Stamp{std::int64_t{seconds} * 1'000'000'000}; }

/// Ten seconds ahead, a metre a second, with a closure between its ends.
MapFolder straight_path() {
  MapFolder folder;
  std::vector<StampedPose2> poses;
  for (int i = 0; i <= 10; ++i) poses.push_back({at(i), {static_cast<double>(i), 0.0, 0.0}});
  folder.trajectory = Trajectory(poses);
  StampedClosure closure{.from = at(0), .to = at(9)};
  closure.closure.state = ClosureState::kStanding;
  closure.closure.from_T_to = {9.1, 0.0, 0.0};
  folder.closures = {closure, StampedClosure{}};
  folder.covariances.assign(11, Eigen::Vector3d(0.09, 0.01, 0.1).asDiagonal());
  folder.cells =
      CellStates({.origin = {0, 0}, .resolution = 0.1, .columns = 3, .rows = 2}, kOccupiedCell);
  return folder;
}

LaserScan scan_at(Stamp stamp) {
  return {.stamp = stamp,
          .angle_increment_rad = 0.1,
          .range_max_m = 10.0,
          .ranges_m = {1.0F, 2.0F, 3.0F}};
}

struct FolderOnBoard : testing::Test {
  RecordedView view{};
  ViewBoard board{view.sink()};

  void play_to_end(FolderView& folder, double speed = 0.0) const {
    int looks = 0;
    ReplayClock clock(folder.range(), speed, [](const PlaybackState&) {});
    folder.play(clock, [&] { return ++looks < 8; });
  }
};

TEST_F(FolderOnBoard, AllIsKnownAtOnce) {
  MapFolder folder = straight_path();
  folder.summary_json = R"({"complete":true,"submaps":3,"warnings":["beware"],
    "quality":{"verdict":"doubtful","sentence":"Doubtful: why.",
      "measures":{"a":{"verdict":"good","sentence":"fine"},"b":{"verdict":"bad","sentence":"not fine"}},
      "loose_parts":[{"x_m":1,"y_m":2,"path_m":30,"closures":0,"sigma_m":0.7}],
      "open_stretches":[{"x_m":1,"y_m":2,"path_m":30,"sigma_m":0.7},{"x_m":1,"y_m":2,"sigma_m":0.01}],
      "contradictions":[{"x_m":3,"y_m":4,"wall_m":9,"share":0.9,"apart_m":1.0},
        {"x_m":3,"y_m":4,"wall_m":0.2}, 7]}})";
  folder.left_out = {"map.png: gone"};
  FolderView shown(std::move(folder), {}, board);
  EXPECT_EQ(shown.range().end, at(10));
  play_to_end(shown);
  const auto nodes = view.last<msg::Trajectory>("/loopstone/trajectory");
  EXPECT_EQ(nodes.count, 11U);
  EXPECT_FLOAT_EQ(nodes.sigma[3], 0.3F);
  const Json closures = view.list("closures");
  ASSERT_EQ(closures.size(), 2U);
  EXPECT_EQ(closures[0]["to"], 9);
  EXPECT_EQ(view.last<msg::OccupancyGrid>("/map").info.width, 3U);
  EXPECT_EQ(view.last<msg::MapTiles>("/loopstone/tiles").ids.size(), 2U);
  const Json verdict = view.last_json("/loopstone/verdict");
  EXPECT_EQ(verdict["verdict"], "doubtful");
  EXPECT_EQ(verdict["reasons"], Json{"not fine"});
  EXPECT_EQ(verdict["places"].size(), 3U);
  EXPECT_EQ(verdict["complete"], true);
  const Json warnings = view.last_json("/loopstone/warnings")["warnings"];
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_EQ(warnings[0]["text"], "beware");
  EXPECT_EQ(view.last_json("/loopstone/status")["submaps"], 3);
  EXPECT_NEAR(view.last<msg::PoseWithCovarianceStamped>("/pose").pose.pose.position.x, 10.0, 1e-9);
}

TEST_F(FolderOnBoard, ASummaryOfNonsenseShowsTheRest) {
  for (const char* summary :
       {"", "no JSON", "[]", R"({"quality":7,"warnings":{},"path_breaks":[1,{"from_s":"a"}]})",
        R"({"quality":{"measures":[1],"loose_parts":{"x_m":1},"contradictions":[null]},
            "calibration":{"mount_corrected":true,"lidar":{"index":1e300,"yaw_is_off":true,"yaw_rad":3}}})"}) {
    MapFolder folder = straight_path();
    folder.summary_json = summary;
    FolderView shown(std::move(folder), {}, board);
    play_to_end(shown);
    EXPECT_EQ(view.last<msg::Trajectory>("/loopstone/trajectory").count, 11U) << summary;
  }
}

TEST_F(FolderOnBoard, ScansOfThePathAreShown) {
  FolderView shown(straight_path(), {}, board);
  shown.add_scan(scan_at(at(0)));
  shown.add_scan(scan_at(at(9)));
  shown.add_scan(scan_at(Stamp{123}));  // of no pose
  EXPECT_EQ(shown.scans(), 2U);
  shown.add_scan(scan_at(at(5)), 1);  // beyond what may be kept
  EXPECT_EQ(shown.scans(), 2U);
  play_to_end(shown);
  const Json evidence = Json::parse(board.answer("/api/closures/0")->body);
  EXPECT_EQ(evidence["from"]["points"].size(), 6U);
  EXPECT_EQ(evidence["graph"], (Json{9.0, 0.0, 0.0}));
  EXPECT_EQ(evidence["measured"], (Json{9.1, 0.0, 0.0}));
}

TEST_F(FolderOnBoard, TheLaserIsWhereTheMapHasIt) {
  MapFolder folder = straight_path();
  folder.summary_json = R"({"calibration":{"mount_corrected":true,
    "beams":{"corrected":true,"laser_is_mirrored":true},
    "lidar":{"index":0,"yaw_is_off":true,"yaw_rad":{"value":0.5},"place_is_off":false,"x_m":{"value":9}}}})";
  FolderView shown(std::move(folder), {}, board);
  for (int i = 0; i <= 10; ++i) shown.add_scan(scan_at(at(i)));
  play_to_end(shown);
  const auto mount = view.last<msg::TFMessage>("/tf_static").transforms.at(0).transform;
  EXPECT_NEAR(mount.rotation.z, std::sin(0.25), 1e-9);
  EXPECT_NEAR(mount.translation.x, RobotModel{}.lidars[0].robot_T_lidar.x, 1e-9);
  EXPECT_LT(view.last<msg::LaserScan>("/scan").angle_increment, 0.0F);
}

TEST_F(FolderOnBoard, SaysWhenThePathWasBroken) {
  MapFolder folder = straight_path();
  folder.summary_json = R"({"path_breaks":[{"from_s":8.5,"to_s":12,"bridged_by":"nothing"}]})";
  FolderView shown(std::move(folder), {}, board);
  play_to_end(shown);
  EXPECT_EQ(view.last_json("/loopstone/status")["status"], "lost");
}

TEST_F(FolderOnBoard, GoesBackAndStaysThere) {
  FolderView shown(straight_path(), {}, board);
  ReplayClock clock(shown.range(), 0.0, [](const PlaybackState&) {});
  int looks = 0;
  shown.play(clock, [&] {
    // At the end; then where it was sent to, and paused.
    if (++looks == 3) clock.control({.play = false, .speed = 1.0, .seek_to = at(4)});
    return looks < 8;
  });
  EXPECT_NEAR(view.last<msg::PoseWithCovarianceStamped>("/pose").pose.pose.position.x, 4.0, 1e-9);
}

TEST_F(FolderOnBoard, ManyClosePosesAreFewNodes) {
  MapFolder folder;
  std::vector<StampedPose2> poses;
  for (int i = 0; i < 1000; ++i)
    poses.push_back({Stamp{std::int64_t{i} * 1'000'000}, {0.001 * i, 0.0, 0.0}});
  folder.trajectory = Trajectory(poses);
  folder.closures = {{.from = Stamp{137'000'000}, .to = Stamp{138'000'000}}};
  FolderView shown(std::move(folder), {}, board);
  play_to_end(shown);
  const auto nodes = view.last<msg::Trajectory>("/loopstone/trajectory");
  EXPECT_LT(nodes.count, 10U);
  const Json closure = view.list("closures")[0];
  EXPECT_NEAR(nodes.t[closure["from"].get<std::size_t>()], 0.137, 1e-9);
  EXPECT_NEAR(nodes.t[closure["to"].get<std::size_t>()], 0.138, 1e-9);
}

}  // namespace
}  // namespace loopstone
