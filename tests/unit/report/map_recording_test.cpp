#include "loopstone/report/map_recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/slam/live_map.hpp"
#include "report/live_grid.hpp"
#include "support/played_recording.hpp"
#include "support/pose_near.hpp"
#include "support/segment_world.hpp"
#include "support/temp_dir.hpp"
#include "unit/slam/ring_world.hpp"

namespace loopstone {
namespace {

using test::lines_of;
using test::PlayedRecording;
using test::pose_near;
using test::TempDir;
using test::to_pose2;

constexpr std::int64_t kStart = 1'000'000'000'000;
constexpr std::int64_t kStepNs = 100'000'000;

/// Once and a third of a time around a block, 10 scans a second, odometry that is 2 % too long.
std::vector<SensorMessage> round_and_a_third() {
  std::vector<SensorMessage> messages;
  const auto poses = test::drive_through(
      {{1.5, 1.5}, {12.3, 1.6}, {12.4, 8.4}, {1.6, 8.5}, {1.5, 1.6}, {12.2, 1.5}}, 0.1, 0.12);
  const test::Scanner scanner{
      .angle_increment_rad = radians(1.0), .beams = 271, .range_max_m = 20.0, .noise_m = 0.01};
  const test::Walls walls = test::ring();
  Rng rng(5);
  Pose2 odometry;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Stamp stamp{kStart + static_cast<std::int64_t>(i) * kStepNs};
    if (i > 0) {
      const Pose2 step = poses[i - 1].inverse() * poses[i];
      odometry = odometry * Pose2{1.02 * step.x, 0.0, step.yaw};
    }
    messages.emplace_back(OdometryPose{stamp, odometry});
    auto scan =
        test::scan_from(walls, poses[i], RobotModel{}.lidars[0].robot_T_lidar, scanner, &rng);
    scan.stamp = stamp;
    messages.emplace_back(std::move(scan));
  }
  return messages;
}

/// A run, what the mapper told, and its recording read back.
struct RecordedRun {
  std::vector<LaserScan> scans{};
  std::vector<MapUpdate> updates{};
  MapResult result{};
  std::optional<PlayedRecording> played{};
};

RecordedRun run(const std::vector<SensorMessage>& messages) {
  const TempDir dir;
  RecordedRun made;
  Mapper mapper({}, {}, {2});
  MapRecording recording(dir / "run.mcap", {});
  const auto take = [&] {
    while (auto update = mapper.next_update()) {
      recording.add(*update, mapper);
      made.updates.push_back(std::move(*update));
    }
  };
  for (const SensorMessage& message : messages) {
    if (const auto* scan = std::get_if<LaserScan>(&message)) made.scans.push_back(*scan);
    recording.add(message);
    mapper.add(message);
    take();
  }
  made.result = mapper.finish();
  take();
  EXPECT_FALSE(std::filesystem::exists(dir / "run.mcap"));
  recording.finish(made.result);
  EXPECT_EQ(dir.names(), std::vector<std::string>{"run.mcap"});
  made.played.emplace(dir / "run.mcap");
  return made;
}

class MapRecordingOfARun : public testing::Test {
 protected:
  static void SetUpTestSuite() { run_ = new RecordedRun(run(round_and_a_third())); }
  static void TearDownTestSuite() { delete run_; }

  template <typename M>
  static std::vector<PlayedRecording::Message<M>> all(const std::string& topic) {
    return run_->played->all<M>(topic);
  }
  static const MapResult& result() { return run_->result; }
  static Stamp end() { return result().trajectory.back().stamp + Duration{1'000'000}; }

  /// Stamps of messages that show the map so far.
  template <typename M>
  static void expect_at_most_once_a_second(
      const std::vector<PlayedRecording::Message<M>>& messages) {
    for (std::size_t i = 1; i + 1 < messages.size(); ++i)
      EXPECT_GE((messages[i].recorded - messages[i - 1].recorded).seconds(), 1.0) << i;
    EXPECT_EQ(messages.back().recorded, end());
  }

  static RecordedRun* run_;
};

RecordedRun* MapRecordingOfARun::run_ = nullptr;

TEST_F(MapRecordingOfARun, HasTopicsOfStandardTypes) {
  std::map<std::string, std::string> types;
  for (const auto& [name, topic] : run_->played->topics()) types[name] = topic.type;
  EXPECT_EQ(types, (std::map<std::string, std::string>{
                       {"/scan", "sensor_msgs/LaserScan"},
                       {"/tf", "tf2_msgs/TFMessage"},
                       {"/tf_static", "tf2_msgs/TFMessage"},
                       {"/map", "nav_msgs/OccupancyGrid"},
                       {"/path", "nav_msgs/Path"},
                       {"/submaps", "visualization_msgs/MarkerArray"},
                       {"/loop_closures", "visualization_msgs/MarkerArray"},
                       {"/verdict", "diagnostic_msgs/DiagnosticArray"}}));
}

TEST_F(MapRecordingOfARun, HasEveryScan) {
  const auto scans = all<msg::LaserScan>("/scan");
  ASSERT_EQ(scans.size(), run_->scans.size());
  for (std::size_t i = 0; i < scans.size(); ++i) {
    EXPECT_EQ(scans[i].recorded, run_->scans[i].stamp);
    EXPECT_EQ(scans[i].value.header.stamp, run_->scans[i].stamp);
    EXPECT_EQ(scans[i].value.header.frame_id, "laser");
    ASSERT_EQ(scans[i].value.ranges, run_->scans[i].ranges_m);
  }
}

TEST_F(MapRecordingOfARun, TransformsLeadFromTheMapToTheLaser) {
  const auto mounts = all<msg::TFMessage>("/tf_static");
  ASSERT_EQ(mounts.size(), 1u);
  ASSERT_EQ(mounts[0].value.transforms.size(), 1u);
  const msg::TransformStamped& mount = mounts[0].value.transforms[0];
  EXPECT_EQ(mount.header.frame_id, "base_link");
  EXPECT_EQ(mount.child_frame_id, "laser");
  EXPECT_TRUE(
      pose_near(to_pose2(mount.transform), RobotModel{}.lidars[0].robot_T_lidar, 1e-12, 1e-12));
  EXPECT_EQ(mount.transform.translation.z, RobotModel{}.lidars[0].height_m);

  const auto transforms = all<msg::TFMessage>("/tf");
  ASSERT_EQ(transforms.size(), run_->updates.size() + 1);
  for (std::size_t i = 0; i < transforms.size(); ++i) {
    const auto& both = transforms[i].value.transforms;
    ASSERT_EQ(both.size(), 2u);
    EXPECT_EQ(both[0].header.frame_id, "map");
    EXPECT_EQ(both[0].child_frame_id, "odom");
    EXPECT_EQ(both[1].header.frame_id, "odom");
    EXPECT_EQ(both[1].child_frame_id, "base_link");
    EXPECT_EQ(both[0].header.stamp, transforms[i].recorded);
    EXPECT_EQ(both[1].header.stamp, transforms[i].recorded);
    const Pose2 map_T_robot = to_pose2(both[0].transform) * to_pose2(both[1].transform);
    if (i == run_->updates.size()) {
      EXPECT_EQ(transforms[i].recorded, end());
      EXPECT_TRUE(pose_near(map_T_robot, result().trajectory.back().pose, 1e-9, 1e-9));
      continue;
    }
    EXPECT_EQ(transforms[i].recorded, run_->updates[i].stamp);
    ASSERT_TRUE(pose_near(map_T_robot, run_->updates[i].map_T_robot(), 1e-9, 1e-9));
  }
}

TEST_F(MapRecordingOfARun, TheMapGrowsIntoTheFinishedOne) {
  const auto maps = all<msg::OccupancyGrid>("/map");
  ASSERT_GT(maps.size(), 5u);
  expect_at_most_once_a_second(maps);
  const CellStates cells = cell_states(result().map);
  const msg::OccupancyGrid& last = maps.back().value;
  EXPECT_EQ(last.header.frame_id, "map");
  EXPECT_EQ(last.info.width, static_cast<std::uint32_t>(cells.frame().columns));
  EXPECT_EQ(last.info.height, static_cast<std::uint32_t>(cells.frame().rows));
  EXPECT_EQ(last.info.resolution, 0.05F);
  EXPECT_EQ(last.info.origin.position.x, cells.frame().origin.x());
  EXPECT_EQ(last.info.origin.position.y, cells.frame().origin.y());
  EXPECT_EQ(last.info.origin.orientation.w, 1.0);
  EXPECT_EQ(last.data, cells.cells());
  const auto known = [](const msg::OccupancyGrid& map) {
    return map.data.size() - static_cast<std::size_t>(std::ranges::count(map.data, kUnknownCell));
  };
  EXPECT_LT(2 * known(maps.front().value), known(last));
  // Nearly all of what is occupied at the end was so, or beside it, a second before.
  const msg::OccupancyGrid& before = maps[maps.size() - 2].value;
  const GridFrame frame{.origin = {before.info.origin.position.x, before.info.origin.position.y},
                        .resolution = 0.05,
                        .columns = static_cast<int>(before.info.width),
                        .rows = static_cast<int>(before.info.height)};
  int occupied = 0;
  int was = 0;
  for (int row = 0; row < cells.frame().rows; ++row) {
    for (int column = 0; column < cells.frame().columns; ++column) {
      if (cells[{column, row}] != kOccupiedCell) continue;
      ++occupied;
      const Cell at = frame.cell_of(cells.frame().centre_of({column, row}));
      bool near = false;
      for (int i = 0; i < 9; ++i) {
        const Cell cell{at.column + i % 3 - 1, at.row + i / 3 - 1};
        near = near || (frame.contains(cell) && before.data[frame.index_of(cell)] == kOccupiedCell);
      }
      was += near ? 1 : 0;
    }
  }
  EXPECT_GT(was, 0.9 * occupied);
}

TEST_F(MapRecordingOfARun, ThePathEndsWhereTheTrajectoryEnds) {
  const auto paths = all<msg::Path>("/path");
  ASSERT_GT(paths.size(), 5u);
  expect_at_most_once_a_second(paths);
  const msg::Path& last = paths.back().value;
  ASSERT_EQ(last.poses.size(), result().trajectory.size());
  for (std::size_t i = 0; i < last.poses.size(); ++i) {
    const StampedPose2& pose = result().trajectory.poses()[i];
    EXPECT_EQ(last.poses[i].header.stamp, pose.stamp);
    ASSERT_TRUE(pose_near(to_pose2(last.poses[i].pose), pose.pose, 1e-9, 1e-9));
  }
  // Before, it ends where the robot was then.
  for (std::size_t i = 0; i + 1 < paths.size(); ++i) {
    const auto update = std::ranges::find(run_->updates, paths[i].recorded, &MapUpdate::stamp);
    ASSERT_NE(update, run_->updates.end());
    EXPECT_TRUE(
        pose_near(to_pose2(paths[i].value.poses.back().pose), update->map_T_robot(), 1e-9, 1e-9));
  }
}

TEST_F(MapRecordingOfARun, ClosuresAndSubmapsLieOnThePath) {
  const auto closures = all<msg::MarkerArray>("/loop_closures");
  const MapStatistics& s = result().statistics;
  ASSERT_GT(s.loop_closures_accepted, 0);
  const msg::MarkerArray& last = closures.back().value;
  EXPECT_EQ(closures.back().recorded, end());
  EXPECT_EQ(static_cast<std::int64_t>(lines_of(last, "standing")), s.loop_closures_accepted);
  EXPECT_EQ(static_cast<std::int64_t>(lines_of(last, "waiting") + lines_of(last, "rejected") +
                                      lines_of(last, "revoked")),
            s.loop_closures_rejected);
  const auto on_path = [&](const msg::Point& point) {
    return std::ranges::any_of(result().trajectory.poses(), [&](const StampedPose2& pose) {
      return std::hypot(pose.pose.x - point.x, pose.pose.y - point.y) < 1e-6;
    });
  };
  for (const msg::Marker& marker : last.markers) {
    EXPECT_EQ(marker.header.frame_id, "map");
    // Viewers complain of lists without points.
    EXPECT_EQ(marker.action == msg::Marker::kDelete, marker.points.empty()) << marker.ns;
    EXPECT_TRUE(std::ranges::all_of(marker.points, on_path)) << marker.ns;
  }

  const auto submaps = all<msg::MarkerArray>("/submaps");
  EXPECT_EQ(submaps.back().recorded, end());
  EXPECT_GT(submaps.size(), 2u);
  std::set<std::string> numbers;
  std::size_t origins = 0;
  for (const msg::Marker& marker : submaps.back().value.markers) {
    if (marker.type == msg::Marker::kText) numbers.insert(marker.text);
    if (marker.type != msg::Marker::kPoints) continue;
    origins += marker.points.size();
    EXPECT_TRUE(std::ranges::all_of(marker.points, on_path));
  }
  EXPECT_EQ(static_cast<std::int64_t>(origins), s.submaps);
  EXPECT_EQ(numbers.size(), origins);
}

TEST_F(MapRecordingOfARun, EndsWithTheVerdict) {
  const auto told = all<msg::DiagnosticArray>("/verdict");
  ASSERT_GE(told.size(), 2u);
  EXPECT_EQ(told.front().value.status.front().name, "loopstone: tracking");
  EXPECT_EQ(told.front().value.status.front().message, "tracked");
  const auto& statuses = told.back().value.status;
  EXPECT_EQ(told.back().recorded, end());
  ASSERT_EQ(statuses.size(), result().verdict.measures.size() + 2);
  EXPECT_EQ(statuses[0].name, "loopstone: map");
  EXPECT_EQ(statuses[0].message, result().verdict.sentence);
  EXPECT_EQ(statuses[0].hardware_id, RobotModel{}.name);
  std::map<std::string, std::string> values;
  for (const msg::KeyValue& value : statuses[0].values) values[value.key] = value.value;
  EXPECT_EQ(values.at("verdict"), to_string(result().verdict.overall));
  EXPECT_EQ(values.at("scans"), std::to_string(result().statistics.scans));
  for (const QualityMeasure& measure : result().verdict.measures) {
    ASSERT_TRUE(values.contains(measure.name)) << measure.name;
    if (measure.verdict == Verdict::kUnknown) {
      EXPECT_EQ(values.at(measure.name), "unknown");
    } else {
      EXPECT_NEAR(std::stod(values.at(measure.name)), measure.value,
                  1e-5 * std::abs(measure.value) + 1e-12);
    }
  }
}

/// What the only status of the only message says.
msg::DiagnosticStatus told_of(const MapEvent& event) {
  const TempDir dir;
  const Mapper mapper({}, {}, {1});
  MapRecording recording(dir / "a.mcap", {});
  MapUpdate update{.stamp = {kStart}, .status = TrackingStatus::kLost};
  recording.add(update, mapper);
  update.stamp = update.stamp + Duration{kStepNs};
  update.events = {event};
  recording.add(update, mapper);
  recording.finish({});
  const auto told = PlayedRecording(dir / "a.mcap").all<msg::DiagnosticArray>("/verdict");
  EXPECT_EQ(told.size(), 3u);
  EXPECT_EQ(told.at(0).value.status.at(0).level, msg::DiagnosticStatus::kError);
  EXPECT_EQ(told.at(1).value.status.size(), 1u);
  EXPECT_EQ(told.at(1).value.header.stamp, update.stamp);
  return told.at(1).value.status.at(0);
}

TEST(MapRecording, FaultsAreToldAsTheyBeginAndEnd) {
  const LaserEpisode blocked{.fault = LaserFault::kBlocked, .lidar = 1, .scans = 7};
  EXPECT_EQ(told_of(LaserFaultChanged{blocked}).name, "loopstone: laser_2");
  EXPECT_EQ(told_of(LaserFaultChanged{blocked}).level, msg::DiagnosticStatus::kError);
  EXPECT_EQ(told_of(LaserFaultChanged{blocked, true}).level, msg::DiagnosticStatus::kOk);
  EXPECT_EQ(told_of(LaserFaultChanged{blocked, true}).message, "no longer blocked");
  OdometryEpisode scaled{.part = OdometryPart::kTranslation, .fault = OdometryFault::kScaled};
  EXPECT_EQ(told_of(OdometryFaultChanged{scaled}).name, "loopstone: odometry translation");
  EXPECT_EQ(told_of(OdometryFaultChanged{scaled}).level, msg::DiagnosticStatus::kWarn);
  scaled.over = true;
  EXPECT_EQ(told_of(OdometryFaultChanged{scaled}).level, msg::DiagnosticStatus::kOk);
  const msg::DiagnosticStatus gap =
      told_of(PathBroken{{.from = {kStart}, .to = {kStart + 2'500'000'000}}});
  EXPECT_EQ(gap.name, "loopstone: path");
  EXPECT_THAT(gap.message, testing::HasSubstr("2.5 s"));
}

TEST(MapRecording, OfNothingIsARecordingToo) {
  const TempDir dir;
  MapRecording recording(dir / "a.mcap", {});
  recording.finish(Mapper({}, {}, {1}).finish());
  const PlayedRecording played(dir / "a.mcap");
  const auto maps = played.all<msg::OccupancyGrid>("/map");
  ASSERT_EQ(maps.size(), 1u);
  EXPECT_EQ(maps[0].value.data, std::vector<std::int8_t>{kUnknownCell});
  EXPECT_TRUE(played.all<msg::Path>("/path").at(0).value.poses.empty());
  EXPECT_FALSE(played.topics().contains("/tf"));
}

TEST(MapRecording, EachLaserHasItsTopicAndLatecomersGetAllMounts) {
  const TempDir dir;
  RobotModel robot;
  robot.lidars.push_back({"rear", {-0.2, 0.0, kPi}, 0.3});
  MapRecording recording(dir / "a.mcap", robot);
  LaserScan scan{.stamp = {kStart}, .range_max_m = 10.0, .ranges_m = {1.0F, 2.0F}};
  for (int i = 0; i < 3; ++i) {
    scan.lidar = 0;
    recording.add(scan);
    scan.lidar = 1;
    recording.add(scan);
    scan.stamp = scan.stamp + Duration{kStepNs};
  }
  scan.robot_T_lidar = Pose2{-0.3, 0.0, kPi};  // it was moved
  recording.add(scan);
  recording.finish({});
  const PlayedRecording played(dir / "a.mcap");
  EXPECT_EQ(played.all<msg::LaserScan>("/scan").size(), 3u);
  const auto rear = played.all<msg::LaserScan>("/scan_2");
  ASSERT_EQ(rear.size(), 4u);
  EXPECT_EQ(rear[0].value.header.frame_id, "laser_2");
  const auto mounts = played.all<msg::TFMessage>("/tf_static");
  ASSERT_EQ(mounts.size(), 3u);
  EXPECT_EQ(mounts[1].value.transforms.size(), 2u);
  ASSERT_EQ(mounts[2].value.transforms.size(), 2u);
  EXPECT_EQ(mounts[2].value.transforms[1].child_frame_id, "laser_2");
  EXPECT_EQ(mounts[2].value.transforms[1].transform.translation.x, -0.3);
}

TEST(MapRecording, WithoutItsEndLeavesNothing) {
  const TempDir dir;
  {
    MapRecording recording(dir / "a.mcap", {});
    recording.add(LaserScan{.range_max_m = 10.0, .ranges_m = {1.0F}});
  }
  EXPECT_TRUE(dir.names().empty());
  EXPECT_THROW(MapRecording(dir / "none/a.mcap", {}), DataError);
}

/// A submap of one scan that stands in a ring, so many tiles to the left.
MapSnapshot snapshot_at(const std::vector<double>& places_m) {
  MapSnapshot snapshot;
  for (const double x : places_m) {
    auto scan = std::make_shared<MappedScan>();
    scan->scan = {.angle_increment_rad = radians(1.0), .range_max_m = 10.0};
    scan->scan.ranges_m.assign(360, 2.0F);
    scan->is_key = true;
    const Pose2 place{x, 0.3, 0.0};
    snapshot.submaps.push_back(
        {.id = {snapshot.submaps.size()},
         .map_T_submap = place,
         .map_T_local = place,
         .scans = std::make_shared<const MappedScans>(MappedScans{std::move(scan)})});
  }
  return snapshot;
}

TEST(LiveGrid, ShowsWhatTheLiveMapShows) {
  LiveMap live({}, 0.25);
  LiveGrid grid(1'000'000);
  EXPECT_FALSE(grid.update(live));
  // It grows to either side, and then a submap moves.
  std::vector<double> places{0.0};
  for (const double next : {-6.0, 9.0, 0.0}) {
    live.refresh(snapshot_at(places));
    EXPECT_TRUE(grid.update(live));
    EXPECT_FALSE(grid.update(live));
    const CellStates all = cell_states(live.map());
    const CellStates& shown = grid.cells();
    int known = 0;
    for (int row = 0; row < shown.frame().rows; ++row) {
      for (int column = 0; column < shown.frame().columns; ++column) {
        const Cell at = all.frame().cell_of(shown.frame().centre_of({column, row}));
        ASSERT_EQ((shown[{column, row}]), all.value_or(at, kUnknownCell)) << column << " " << row;
        known += shown[{column, row}] == kUnknownCell ? 0 : 1;
      }
    }
    EXPECT_EQ(known, std::ranges::count_if(all.cells(), [](int s) { return s != kUnknownCell; }));
    if (next == 0.0) places.front() = 0.5;
    places.push_back(next);
  }
}

TEST(LiveGrid, AMapThatIsTooLargeIsNotShown) {
  LiveMap live({}, 0.25);
  LiveGrid grid(100 * OccupancyTile::kCells);
  live.refresh(snapshot_at({0.0}));
  EXPECT_TRUE(grid.update(live));
  live.refresh(snapshot_at({0.0, 1e3}));
  EXPECT_FALSE(grid.update(live));
  EXPECT_TRUE(grid.cells().empty());
  live.refresh(snapshot_at({0.0, 1e3, 3.0}));
  EXPECT_FALSE(grid.update(live));
}

}  // namespace
}  // namespace loopstone
