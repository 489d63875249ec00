#include "loopstone/slam/mapper.hpp"

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <exception>
#include <string_view>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/base/option_list.hpp"
#include "loopstone/base/release_memory.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/odometry/scan_queue.hpp"
#include "loopstone/slam/front_end.hpp"
#include "loopstone/slam/surface_adjustment.hpp"
#include "slam/back_end_worker.hpp"
#include "slam/fault_events.hpp"
#include "slam/map_board.hpp"
#include "slam/map_finish.hpp"
#include "slam/odom_frame.hpp"
#include "slam/stopwatch.hpp"

namespace loopstone {

namespace {

/// Scans that differ less than this from the last one mapped add next to nothing to the final map.
constexpr double kStillCells = 1.0;
constexpr double kStillRad = 0.04;

/// From a submap's origin its robot is never farther.
constexpr double kMostSubmapTravelM = 300.0;

/// Raised whenever a field list of that part changes.
constexpr std::uint16_t kScanQueueVersion = 3;
constexpr std::uint16_t kFrontEndVersion = 2;
constexpr std::uint16_t kMapperVersion = 3;

/// Of updates that nobody takes, so many are kept.
constexpr std::size_t kMostUpdates = 1000;

/// Of the axis along which a pose is known least, [0, pi).
double open_direction(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(covariance.topLeftCorner<2, 2>());
  const Eigen::Vector2d axis = solver.eigenvectors().col(1);
  const double angle = std::atan2(axis.y(), axis.x());
  return angle < 0.0 ? angle + kPi : (angle >= kPi ? 0.0 : angle);
}

/// On axes that are turned by a frame.
Eigen::Matrix3d turned(const Eigen::Matrix3d& covariance, const Pose2& frame) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = frame.rotation();
  return turn * covariance * turn.transpose();
}

/// How odometry fared beside the laser, and the laser by itself.
void report_sensors(const FrontEnd& front_end, const ScanQueue& queue, MapResult& result) {
  MapStatistics& statistics = result.statistics;
  const OdometryCheck& check = front_end.odometry_check();
  statistics.laser_heading_offset_rad = check.laser_heading_offset_rad();
  statistics.wheels_with_gyro = queue.odometer().wheels_with_gyro();
  statistics.scans_repeated = static_cast<std::int64_t>(front_end.laser_check().most_repeated());
  statistics.odometry_jumps = check.translation().jumps() + check.rotation().jumps();
  statistics.odometry_translation_scale = check.translation().scale().value_or(0.0);
  statistics.odometry_rotation_scale = check.rotation().scale().value_or(0.0);
  statistics.odometry_distrusted_s = check.distrusted_s();
  result.odometry_episodes = check.episodes();
  result.laser_episodes = front_end.laser_check().episodes();
}

/// The figures that follow from the finished trajectory and graph.
void count(MapResult& result) {
  auto& statistics = result.statistics;
  for (const auto& closure : result.loop_closures) {
    ++(closure.stands() ? statistics.loop_closures_accepted : statistics.loop_closures_rejected);
  }
  if (!result.trajectory.empty()) {
    statistics.duration_s =
        (result.trajectory.back().stamp - result.trajectory.front().stamp).seconds();
  }
  statistics.graph_cost = graph_cost(result.graph);
}

}  // namespace

class Mapper::Impl {
 public:
  Impl(const RobotModel& robot, const MapOptions& options, Threads threads)
      : robot_(robot),
        options_(options),
        threads_(threads),
        scan_queue_(robot.wheels),
        front_end_(options.front_end, options.match, options.submap),
        back_end_(options, threads, board_) {}

  void add(const SensorMessage& message) {
    scan_queue_.add(message);
    while (auto scan = scan_queue_.next()) add_scan(std::move(*scan));
  }

  [[nodiscard]] std::optional<MapUpdate> next_update() {
    if (updates_.empty()) return {};
    MapUpdate update = std::move(updates_.front());
    updates_.pop_front();
    update.missed = std::exchange(updates_missed_, 0);
    return update;
  }

  [[nodiscard]] MapSnapshot snapshot() const { return board_.snapshot(); }
  [[nodiscard]] std::int64_t scans() const { return static_cast<std::int64_t>(track_.size()); }

  [[nodiscard]] MapResult finish(const ProgressCallback& progress, const std::stop_token& cancel);
  [[nodiscard]] std::future<std::vector<StateChunk>> save_state();
  void restore_state(std::span<const StateChunk> chunks);

  template <typename Archive>
  void archive(Archive& a) {
    a(track_, last_mapped_, statistics_, gyro_scans_, breaks_, odom_frame_, was_lost_, submaps_,
      submaps_frozen_);
  }

 private:
  void add_scan(LaserScan scan);
  void count_scan(const TrackedScan& tracked);
  void tell(const TrackedScan& tracked);
  [[nodiscard]] std::vector<MapEvent> events_of(const TrackedScan& tracked);
  void put_up_faults();
  void hand_over(LaserScan scan, const Pose2& robot_T_lidar, TrackedScan tracked);
  [[nodiscard]] Pose2 end_of_sweep(const LaserScan& scan, const Pose2& local_T_robot) const;
  [[nodiscard]] MapResult result_of_back_end() const;
  void adjust(MapResult& result) const;

  RobotModel robot_;
  MapOptions options_;
  Threads threads_;
  ScanQueue scan_queue_;
  FrontEnd front_end_;
  MapBoard board_{};
  BackEndWorker back_end_;
  std::deque<TrackedPose> track_{};
  Pose2 last_mapped_{};
  MapStatistics statistics_{};
  std::int64_t gyro_scans_ = 0;  ///< whose heading alone was known
  std::vector<PathBreak> breaks_{};
  OdomFrame odom_frame_{};
  bool was_lost_ = false;
  std::size_t submaps_ = 0;  ///< begun
  std::size_t submaps_frozen_ = 0;
  FaultEvents fault_events_{};
  std::deque<MapUpdate> updates_{};
  std::int64_t updates_missed_ = 0;
};

void Mapper::Impl::add_scan(LaserScan scan) {
  const Stopwatch watch;
  const Pose2 robot_T_lidar = mount_of(scan, robot_);
  const auto odometry = scan_queue_.reading_at(scan.stamp);
  std::optional<Pose2> odom_T_robot;
  if (odometry && odometry->has_translation) odom_T_robot = odometry->odom_T_robot;
  if (odometry && !odometry->has_translation) ++gyro_scans_;

  TrackedScan tracked = front_end_.add(scan, robot_T_lidar, odometry);
  count_scan(tracked);
  track_.push_back({scan.stamp, tracked.local_T_robot, odom_T_robot});
  if (tracked.path_break) {
    tracked.path_break->to_scan = track_.size() - 1;
    breaks_.push_back(*tracked.path_break);
  }
  tell(tracked);
  statistics_.front_end_s += watch.seconds();
  hand_over(std::move(scan), robot_T_lidar, std::move(tracked));
}

void Mapper::Impl::count_scan(const TrackedScan& tracked) {
  if (!tracked.used) ++statistics_.scans_dropped;
  if (tracked.searched) ++statistics_.searches;
  if (tracked.key) ++statistics_.key_scans;
  if (!track_.empty() && tracked.status == MatchStatus::kDegenerate) {
    const Pose2 motion = track_.back().local_T_robot.inverse() * tracked.local_T_robot;
    statistics_.degenerate_travel_m += std::hypot(motion.x, motion.y);
  }
}

/// An update of the newest scan, for whoever drives by it.
void Mapper::Impl::tell(const TrackedScan& tracked) {
  const bool may_jump = tracked.searched || tracked.path_break || was_lost_;
  was_lost_ = tracked.left_out;
  MapUpdate update;
  update.stamp = track_.back().stamp;
  update.scan = scans() - 1;
  update.odom_T_robot =
      odom_frame_.follow(tracked.local_T_robot, tracked.guess_local_T_robot, may_jump);
  const Pose2 map_T_local = board_.map_T_local();
  update.map_T_odom = map_T_local * odom_frame_.local_T_odom();
  update.covariance =
      turned(tracked.path_break ? tracked.path_break->covariance : tracked.covariance, map_T_local);
  update.status = tracked.tracking;
  if (update.status == TrackingStatus::kDegenerate)
    update.open_direction_rad = open_direction(update.covariance);
  if (tracked.key) update.key_scan = static_cast<std::size_t>(statistics_.key_scans - 1);
  update.events = events_of(tracked);
  if (updates_.size() == kMostUpdates) {
    updates_.pop_front();
    ++updates_missed_;
  }
  updates_.push_back(std::move(update));
}

std::vector<MapEvent> Mapper::Impl::events_of(const TrackedScan& tracked) {
  std::vector<MapEvent> events =
      fault_events_.changes(front_end_.odometry_check(), front_end_.laser_check());
  if (tracked.path_break) events.emplace_back(PathBroken{*tracked.path_break});
  if (!events.empty() || track_.size() == 1) put_up_faults();
  for (std::size_t i = 0; i < tracked.finished.size(); ++i)
    events.emplace_back(SubmapFrozen{{submaps_frozen_++}});
  if (tracked.starts_submap) events.emplace_back(SubmapOpened{{submaps_++}});
  for (MapEvent& event : board_.take_events()) events.push_back(std::move(event));
  return events;
}

void Mapper::Impl::put_up_faults() {
  board_.set_faults({.first_scan = track_.front().stamp,
                     .odometry = front_end_.odometry_check().episodes(),
                     .laser = front_end_.laser_check().episodes(),
                     .breaks = breaks_});
}

/// Gives the back end what the front end is done with.
void Mapper::Impl::hand_over(LaserScan scan, const Pose2& robot_T_lidar, TrackedScan tracked) {
  const std::size_t index = track_.size() - 1;
  const Pose2& local_T_robot = tracked.local_T_robot;
  std::optional<KeyScan> key;
  if (tracked.key) {
    key = {scan.stamp, local_T_robot, tracked.covariance, index, tracked.starts_submap};
    if (tracked.path_break && tracked.path_break->bridge != BreakBridge::kLaser)
      key->across = tracked.path_break->covariance;
  }
  // Standing still adds nothing to the map, and a fast scanner no more than a slow one.
  const Pose2 since = last_mapped_.inverse() * local_T_robot;
  const bool moved = std::hypot(since.x, since.y) > kStillCells * options_.map.resolution_m ||
                     std::abs(since.yaw) > kStillRad;
  if (key || (tracked.used && !tracked.left_out && moved)) {
    last_mapped_ = local_T_robot;
    const Pose2 end = end_of_sweep(scan, local_T_robot);
    back_end_.add_scan({std::move(scan), index, robot_T_lidar, local_T_robot, end, key.has_value()},
                       key);
  }
  back_end_.add_submaps(std::move(tracked.finished));
}

/// Where the robot is when the sweep of the newest scan ends, if it goes on as it came.
Pose2 Mapper::Impl::end_of_sweep(const LaserScan& scan, const Pose2& local_T_robot) const {
  const double sweep_s = sweep_seconds(scan);
  if (track_.size() < 2 || sweep_s == 0.0) return local_T_robot;
  const TrackedPose& before = track_[track_.size() - 2];
  const double seconds = (scan.stamp - before.stamp).seconds();
  if (!(seconds > 0.0)) return local_T_robot;
  const Pose2 motion = before.local_T_robot.inverse() * local_T_robot;
  return local_T_robot * exp(Tangent2(log(motion) * (sweep_s / seconds)));
}

std::future<std::vector<StateChunk>> Mapper::Impl::save_state() {
  std::vector<StateChunk> chunks;
  chunks.push_back(save_chunk("SCAN", kScanQueueVersion, scan_queue_));
  chunks.push_back(save_chunk("FRNT", kFrontEndVersion, front_end_));
  chunks.push_back(save_chunk("MAPR", kMapperVersion, *this));
  return back_end_.add_state(std::move(chunks));
}

void Mapper::Impl::restore_state(std::span<const StateChunk> chunks) {
  constexpr std::array<std::string_view, 6> kTags{"SCAN", "FRNT", "MAPR", "WAIT", "BACK", "MAPD"};
  refuse_unknown(chunks, kTags);
  load_chunk(chunks, "SCAN", kScanQueueVersion, scan_queue_);
  load_chunk(chunks, "FRNT", kFrontEndVersion, front_end_);
  load_chunk(chunks, "MAPR", kMapperVersion, *this);
  back_end_.restore(chunks);
  if (!back_end_.scans_fit(track_.size())) {
    throw DataError({chunks.front().origin.path}, "damaged: scans that contradict the path");
  }
  const double reach_m = options_.front_end.range_max_m + kMostSubmapTravelM;
  if (!front_end_.submaps_lie_within(reach_m) ||
      !back_end_.back_end().submaps_lie_within(reach_m)) {
    throw DataError({chunks.front().origin.path},
                    "damaged: a submap larger than the laser reaches");
  }
  // What was told before the run was broken off is not told again.
  (void)fault_events_.changes(front_end_.odometry_check(), front_end_.laser_check());
  if (!track_.empty()) put_up_faults();
  back_end_.show_restored();
}

/// What the back end has, and what was counted on the way.
MapResult Mapper::Impl::result_of_back_end() const {
  const BackEnd& back_end = back_end_.back_end();
  MapResult result;
  result.graph = back_end.graph();
  result.loop_closures = back_end.closures();
  std::vector<std::size_t> node_scans;
  for (const KeyScan& key : back_end.keys()) {
    result.node_stamps.push_back(key.stamp);
    node_scans.push_back(key.scan);
  }
  result.breaks = breaks_;
  find_ties(result.breaks, result.graph, node_scans);
  MapStatistics& statistics = result.statistics;
  statistics = statistics_;
  statistics.scans = scans();
  statistics.key_scans_thinned =
      statistics.key_scans - static_cast<std::int64_t>(node_scans.size());
  statistics.path_length_m = back_end.path_length_m();
  statistics.submaps = static_cast<std::int64_t>(back_end.submap_count());
  statistics.loop_closing_s = back_end.loop_closing_s();
  statistics.optimisation_s = back_end.optimisation_s();
  report_sensors(front_end_, scan_queue_, result);
  return result;
}

/// Moves all key scans onto the surfaces that they share.
void Mapper::Impl::adjust(MapResult& result) const {
  if (!options_.adjustment.enabled) return;
  const Stopwatch watch;
  const SurfaceOptions surfaces{.range_max_m = options_.front_end.range_max_m,
                                .points_max = options_.adjustment.points_max};
  auto adjusted = adjust_to_surfaces(result.graph, key_surfaces(back_end_.scans(), surfaces),
                                     options_.adjustment, threads_);
  result.graph.poses = std::move(adjusted.poses);
  result.statistics.surface_spread_before_m = adjusted.spread_before_m;
  result.statistics.surface_spread_m = adjusted.spread_after_m;
  result.statistics.adjustment_s = watch.seconds();
}

MapResult Mapper::Impl::finish(const ProgressCallback& progress, const std::stop_token& cancel) {
  constexpr std::int64_t kStages = 5;
  bool complete = true;
  const auto goes_on_to = [&](std::int64_t stage) {
    if (complete &&
        (cancel.stop_requested() || (progress && !progress({"finishing", stage, kStages}))))
      complete = false;
    return complete;
  };
  scan_queue_.finish();
  while (auto scan = scan_queue_.next()) add_scan(std::move(*scan));
  back_end_.add_submaps(front_end_.finish());
  back_end_.finish([&] { return goes_on_to(0); });
  MapResult result = result_of_back_end();

  release_unused_memory();
  const PoseGraph solved = result.graph;
  if (goes_on_to(1)) adjust(result);
  // How well edges agree is judged at the graph's own solution: the adjustment knows more than they
  // do.
  const Stopwatch judging_graph;
  if (goes_on_to(2))
    result.graph_quality = assess_graph(solved, result.graph.poses, result.loop_closures);
  result.statistics.judging_s = judging_graph.seconds();
  result.loop_closures = at_poses_of(result.graph, std::move(result.loop_closures));

  PlacedScans placed =
      place_scans(track_, back_end_.back_end().keys(), result.graph.poses, back_end_.scans());
  result.trajectory = std::move(placed.trajectory);
  result.odometry = std::move(placed.odometry);
  track_ = {};  // it is in the trajectories now
  release_unused_memory();

  const Stopwatch rendering;
  if (!goes_on_to(3)) placed.on_map = some_of(placed.on_map);
  try {
    result.map =
        build_occupancy_map(placed.on_map, robot_.footprint_radius_m, options_.map, threads_);
  } catch (const std::exception& error) {
    result.map_failure = error.what();
  }
  result.statistics.rendering_s = rendering.seconds();
  count(result);

  release_unused_memory();
  const Stopwatch judging;
  if (goes_on_to(4) && result.map_failure.empty()) {
    result.quality = assess_map(placed.on_map, threads_);
    result.verdict = judge_map(result);
  }
  result.statistics.judging_s += judging.seconds();
  result.warnings = warnings_of(result, options_, gyro_scans_ > 0);
  result.complete = complete;
  return result;
}

Mapper::Mapper(const RobotModel& robot, const MapOptions& options, Threads threads)
    : impl_((require_valid(options), std::make_unique<Impl>(robot, options, threads))) {}
Mapper::~Mapper() = default;

void Mapper::add(const SensorMessage& message) { impl_->add(message); }
std::optional<MapUpdate> Mapper::next_update() { return impl_->next_update(); }
MapSnapshot Mapper::snapshot() const { return impl_->snapshot(); }
MapResult Mapper::finish(const ProgressCallback& progress, const std::stop_token& cancel) {
  return impl_->finish(progress, cancel);
}
std::future<std::vector<StateChunk>> Mapper::save_state() { return impl_->save_state(); }
void Mapper::restore_state(std::span<const StateChunk> chunks) { impl_->restore_state(chunks); }
std::int64_t Mapper::scans() const { return impl_->scans(); }

}  // namespace loopstone
