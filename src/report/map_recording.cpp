#include "loopstone/report/map_recording.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "formats/known_mounts.hpp"
#include "formats/message_scan.hpp"
#include "formats/recording_writer.hpp"
#include "formats/topic_names.hpp"
#include "formats/topic_writer.hpp"
#include "loopstone/base/thinned.hpp"
#include "loopstone/sensor/mounted_scan.hpp"
#include "loopstone/slam/live_map.hpp"
#include "loopstone/slam/map_snapshot.hpp"
#include "report/live_grid.hpp"
#include "report/map_messages.hpp"
#include "report/written_states.hpp"

namespace loopstone {
namespace {

constexpr Duration kPeriod = Duration::from_milliseconds(1000);
/// What the finished map says comes so long after the last scan: viewers ignore what contradicts an
/// earlier message of the same time.
constexpr Duration kAfterwards = Duration::from_milliseconds(1);
constexpr double kCellsPerS = 1e6;
constexpr double kSubmapsPerS = 1e3;
/// A way so far is sent again and again.
constexpr std::size_t kPosesSoFar = 500;
constexpr std::size_t kPosesAtEnd = 20'000;

/// With the last one, which says where the robot is.
template <typename Poses>
std::vector<StampedPose2> thinned_path(const Poses& poses, std::size_t count) {
  std::vector<StampedPose2> path = thinned(poses, count);
  if (!poses.empty() && path.back().stamp != poses.back().stamp) path.push_back(poses.back());
  return path;
}

/// What is not sent all the time.
class Pace {
 public:
  [[nodiscard]] bool is_due(Stamp now, Duration period) const {
    return !last_ || now - *last_ >= period || now < *last_;
  }
  void note(Stamp now) { last_ = now; }

 private:
  std::optional<Stamp> last_{};
};

Duration longer(Duration period, double seconds) {
  return std::max(period, Duration::from_seconds(seconds));
}

std::vector<ClosureLine> lines_of(const MapSnapshot& snapshot) {
  std::vector<ClosureLine> lines;
  for (const LoopClosure& closure : snapshot.closures) {
    const std::size_t from = closure.from_submap.index;
    const std::size_t to = closure.to_submap.index;
    if (std::max(from, to) >= snapshot.submaps.size()) continue;
    lines.push_back({closure.state, snapshot.submaps[from].map_T_submap.translation(),
                     snapshot.submaps[to].map_T_submap.translation()});
  }
  return lines;
}

}  // namespace

class MapRecording::Impl {
 public:
  Impl(const std::string& path, const RobotModel& robot, const OccupancyOptions& map)
      : writer_(create_mcap(path)),
        robot_(robot),
        live_(map, robot.footprint_radius_m),
        grid_(map.most_cells) {}

  [[nodiscard]] const RobotModel& robot() const { return robot_; }
  void add(const LaserScan& scan);
  void add(const MapUpdate& update, const Mapper& mapper);
  void finish(const MapResult& result);

 private:
  void send_transforms(Stamp stamp, const Pose2& map_T_odom);
  void tell(const MapUpdate& update);
  void show(const MapSnapshot& snapshot, const MapUpdate& update);
  void show_map(const MapSnapshot& snapshot, Stamp stamp);
  void show_path(const MapSnapshot& snapshot, const MapUpdate& update);
  void show_graph(const MapSnapshot& snapshot, Stamp stamp);
  void send_diagnostics(Stamp stamp, std::vector<msg::DiagnosticStatus> told);
  template <typename M>
  void send_latched(const char* topic, Stamp stamp, const M& message) {
    writer_.send(topic, stamp, message, true);
  }

  TopicWriter writer_;
  RobotModel robot_;
  KnownMounts mounts_{};
  Stamp last_{};  ///< of scans and updates, the latest
  Pose2 odom_T_robot_{};
  std::optional<TrackingStatus> status_{};
  std::vector<Stamp> submap_stamps_{};  ///< of the first scan of each

  LiveMap live_;
  LiveGrid grid_;
  bool grid_changed_ = false;
  std::vector<Pose2> shown_submaps_{};
  std::vector<ClosureLine> shown_closures_{};
  Pace snapshots_{};
  Pace maps_{};
  Pace graphs_{};
};

void MapRecording::Impl::add(const LaserScan& scan) {
  last_ = std::max(last_, scan.stamp);
  if (const auto all = mounts_.change(scan, robot_)) send_latched("/tf_static", scan.stamp, *all);
  writer_.send(scan_topic(scan.lidar), scan.stamp, to_message(scan, laser_frame(scan.lidar)));
}

void MapRecording::Impl::add(const MapUpdate& update, const Mapper& mapper) {
  last_ = std::max(last_, update.stamp);
  odom_T_robot_ = update.odom_T_robot;
  send_transforms(update.stamp, update.map_T_odom);
  tell(update);
  for (const MapEvent& event : update.events) {
    const auto* opened = std::get_if<SubmapOpened>(&event);
    if (opened != nullptr && opened->id.index == submap_stamps_.size())
      submap_stamps_.push_back(update.stamp);
  }
  if (!snapshots_.is_due(update.stamp, kPeriod)) return;
  snapshots_.note(update.stamp);
  show(mapper.snapshot(), update);
}

void MapRecording::Impl::send_transforms(Stamp stamp, const Pose2& map_T_odom) {
  writer_.send(
      "/tf", stamp,
      msg::TFMessage{{transform_message(stamp, kMapFrame, kOdometryFrame, map_T_odom),
                      transform_message(stamp, kOdometryFrame, kBaseFrame, odom_T_robot_)}});
}

/// What holds the pose when that changes, and faults.
void MapRecording::Impl::tell(const MapUpdate& update) {
  std::vector<msg::DiagnosticStatus> told;
  if (update.status != status_) told.push_back(diagnostic_of(update));
  status_ = update.status;
  for (const MapEvent& event : update.events) {
    if (auto fault = diagnostic_of(event)) told.push_back(std::move(*fault));
  }
  if (!told.empty()) send_diagnostics(update.stamp, std::move(told));
}

void MapRecording::Impl::send_diagnostics(Stamp stamp, std::vector<msg::DiagnosticStatus> told) {
  for (msg::DiagnosticStatus& status : told) status.hardware_id = robot_.name;
  writer_.send("/verdict", stamp,
               msg::DiagnosticArray{.header = {stamp, ""}, .status = std::move(told)});
}

void MapRecording::Impl::show(const MapSnapshot& snapshot, const MapUpdate& update) {
  // Of updates that were missed nobody told when submaps began.
  for (std::size_t i = submap_stamps_.size(); i < snapshot.submaps.size(); ++i)
    submap_stamps_.push_back(snapshot.submaps[i].scans->front()->scan.stamp);
  show_map(snapshot, update.stamp);
  show_path(snapshot, update);
  show_graph(snapshot, update.stamp);
}

void MapRecording::Impl::show_map(const MapSnapshot& snapshot, Stamp stamp) {
  live_.refresh(snapshot);
  grid_changed_ = grid_.update(live_) || grid_changed_;
  const auto cells = static_cast<double>(grid_.cells().cells().size());
  if (!grid_changed_ || grid_.cells().empty() ||
      !maps_.is_due(stamp, longer(kPeriod, cells / kCellsPerS)))
    return;
  maps_.note(stamp);
  grid_changed_ = false;
  send_latched("/map", stamp, to_message(grid_.cells(), stamp));
}

void MapRecording::Impl::show_path(const MapSnapshot& snapshot, const MapUpdate& update) {
  std::vector<StampedPose2> path;
  for (const KeyScanSnapshot& key : snapshot.key_scans())
    path.push_back({key.stamp, key.map_T_robot});
  path.push_back({update.stamp, update.map_T_robot()});
  send_latched("/path", update.stamp, path_message(thinned_path(path, kPosesSoFar), update.stamp));
}

void MapRecording::Impl::show_graph(const MapSnapshot& snapshot, Stamp stamp) {
  const auto submaps = static_cast<double>(snapshot.submaps.size());
  if (!graphs_.is_due(stamp, longer(kPeriod, submaps / kSubmapsPerS))) return;
  graphs_.note(stamp);
  std::vector<Pose2> origins;
  for (const SubmapSnapshot& submap : snapshot.submaps) origins.push_back(submap.map_T_submap);
  std::vector<ClosureLine> closures = lines_of(snapshot);
  if (origins != shown_submaps_) send_latched("/submaps", stamp, submap_markers(origins, stamp));
  if (closures != shown_closures_)
    send_latched("/loop_closures", stamp, closure_markers(closures, stamp));
  shown_submaps_ = std::move(origins);
  shown_closures_ = std::move(closures);
}

void MapRecording::Impl::finish(const MapResult& result) {
  if (!result.trajectory.empty()) last_ = std::max(last_, result.trajectory.back().stamp);
  const Stamp end = last_ + kAfterwards;
  if (!result.trajectory.empty())
    send_transforms(end, result.trajectory.back().pose * odom_T_robot_.inverse());
  if (result.map_failure.empty())
    send_latched("/map", end, to_message(states_to_write(result.map), end));
  send_latched("/path", end,
               path_message(thinned_path(result.trajectory.poses(), kPosesAtEnd), end));
  std::vector<Pose2> origins;
  for (const Stamp stamp : submap_stamps_)
    origins.push_back(result.trajectory.at_clamped(stamp).value_or(Pose2{}));
  send_latched("/submaps", end, submap_markers(origins, end));
  send_latched("/loop_closures", end, closure_markers(closure_lines(result), end));
  send_diagnostics(end, diagnostics_of(result));
  writer_.finish();
}

MapRecording::MapRecording(const std::string& path, const RobotModel& robot,
                           const OccupancyOptions& map)
    : impl_(std::make_unique<Impl>(path, robot, map)) {}
MapRecording::~MapRecording() = default;

void MapRecording::add(const SensorMessage& message) {
  const auto* const scan = std::get_if<LaserScan>(&message);
  if (scan == nullptr) return;
  const auto mounted = as_mounted(*scan, impl_->robot());
  impl_->add(mounted ? *mounted : *scan);
}
void MapRecording::add(const MapUpdate& update, const Mapper& mapper) {
  impl_->add(update, mapper);
}
void MapRecording::finish(const MapResult& result) { impl_->finish(result); }

}  // namespace loopstone
