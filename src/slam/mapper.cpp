#include "loopstone/slam/mapper.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <utility>

#include "geometry/symmetric_matrix.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/base/option_list.hpp"
#include "loopstone/base/sound_state.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/covariance.hpp"
#include "loopstone/sensor/mounted_scan.hpp"
#include "loopstone/slam/laser_cover.hpp"
#include "loopstone/slam/mapper_state.hpp"
#include "loopstone/slam/settled_map.hpp"
#include "slam/back_end_worker.hpp"
#include "slam/fault_events.hpp"
#include "slam/finish_steps.hpp"
#include "slam/map_board.hpp"
#include "slam/scan_edges.hpp"
#include "slam/stopwatch.hpp"

namespace loopstone {

namespace {

/// Of the axis along which a pose is known least, [0, pi).
double open_direction(const Eigen::Matrix3d& covariance) {
  const SymmetricEigen<double, 2> axes =
      symmetric_eigen<double, 2>(covariance.topLeftCorner<2, 2>());
  const Eigen::Vector2d axis = axes.vectors.col(1);
  const double angle = std::atan2(axis.y(), axis.x());
  return angle < 0.0 ? angle + kPi : (angle >= kPi ? 0.0 : angle);
}

/// How odometry fared beside the laser, and the laser by itself.
void report_sensors(const FrontEnd& front_end, const ScanQueue& queue, MapResult& result) {
  MapStatistics& statistics = result.statistics;
  const OdometryCheck& check = front_end.odometry_check();
  statistics.laser_heading_offset_rad = check.laser_heading_offset_rad();
  statistics.wheels_with_gyro = queue.odometer().wheels_with_gyro();
  statistics.odometry_is_told = queue.odometer().source() == Odometer::Source::kPoses;
  statistics.scans_repeated = static_cast<std::int64_t>(front_end.laser_check().most_repeated());
  statistics.odometry_jumps = check.translation().jumps() + check.rotation().jumps();
  statistics.odometry_translation_scale = check.translation().scale().value_or(0.0);
  statistics.odometry_rotation_scale = check.rotation().scale().value_or(0.0);
  statistics.odometry_distrusted_s = check.distrusted_s();
  result.odometry_episodes = check.episodes();
  result.laser_episodes = front_end.laser_check().episodes();
}

}  // namespace

class Mapper::Impl {
 public:
  Impl(const RobotModel& robot, const MapOptions& options, Threads threads)
      : robot_(robot),
        options_(options),
        threads_(threads),
        scan_queue_(robot.wheels),
        front_end_(options.front_end, options.match, options.submap, robot.odometry_scale),
        back_end_(options, threads, board_) {}

  void add(const SensorMessage& message) {
    const auto mounted = as_mounted(message, robot_);
    if (so_far_.drives.empty()) {
      scan_queue_.add(mounted ? *mounted : message);
    } else {
      scan_queue_.add(on_maps_clock(mounted ? *mounted : message));
    }
    work_on_scans();
  }

  void begin_drive();

  [[nodiscard]] std::optional<MapUpdate> next_update() {
    if (updates_.empty()) return {};
    MapUpdate update = std::move(updates_.front());
    updates_.pop_front();
    update.missed = std::exchange(updates_missed_, 0);
    return update;
  }

  [[nodiscard]] MapSnapshot snapshot() const { return board_.snapshot(); }
  [[nodiscard]] std::int64_t scans() const {
    return static_cast<std::int64_t>(so_far_.track.size());
  }

  [[nodiscard]] Calibration judge_robot();
  [[nodiscard]] SettledMap settle(const std::function<bool()>& goes_on);
  [[nodiscard]] MapResult finish(const ProgressCallback& progress, const std::stop_token& cancel);
  void set_graph_addition(GraphAddition addition) { addition_ = std::move(addition); }
  [[nodiscard]] std::future<MapperState> save_state();
  void restore_state(MapperState state);

 private:
  void work_on_scans() {
    while (auto scan = scan_queue_.next()) add_scan(std::move(*scan));
  }
  [[nodiscard]] SensorMessage on_maps_clock(SensorMessage message);
  void lay_beside(TrackedScan& tracked) const;
  [[nodiscard]] PathBreak break_before_drive(Stamp to) const;
  void add_scan(LaserScan scan);
  void keep_odometry_in_time();
  void count_scan(const TrackedScan& tracked);
  void tell(const TrackedScan& tracked);
  void place_lost();
  [[nodiscard]] std::vector<MapEvent> events_of(const TrackedScan& tracked);
  void put_up_faults();
  void hand_over(LaserScan scan, const Pose2& robot_T_lidar, TrackedScan tracked);
  void end_log();
  [[nodiscard]] std::optional<PathBreak> break_in_the_end() const;
  [[nodiscard]] Pose2 end_of_sweep(const LaserScan& scan, const Pose2& local_T_robot) const;

  RobotModel robot_;
  MapOptions options_;
  Threads threads_;
  ScanQueue scan_queue_;
  FrontEnd front_end_;
  MapBoard board_{};
  BackEndWorker back_end_;
  MapperState::SoFar so_far_{};
  OdomFrame odom_frame_{};
  FaultEvents fault_events_{};
  std::deque<MapUpdate> updates_{};
  std::int64_t updates_missed_ = 0;
  GraphAddition addition_{};
  bool log_ended_ = false;
};

void Mapper::Impl::add_scan(LaserScan scan) {
  const Stopwatch watch;
  const Pose2 robot_T_lidar = mount_of(scan, robot_);
  const auto odometry = scan_queue_.reading_at(scan.stamp);
  std::optional<Pose2> odom_T_robot;
  if (odometry && odometry->has_translation) odom_T_robot = odometry->odom_T_robot;
  if (odometry && !odometry->has_translation) ++so_far_.gyro_scans;

  TrackedScan tracked = front_end_.add(scan, robot_T_lidar, odometry);
  if (!so_far_.drives.empty()) lay_beside(tracked);
  if (so_far_.drive_begins && tracked.key) {
    tracked.path_break = break_before_drive(scan.stamp);
    so_far_.drive_begins = false;
  }
  keep_odometry_in_time();
  count_scan(tracked);
  so_far_.track.push_back({scan.stamp, tracked.local_T_robot, odom_T_robot});
  if (tracked.path_break) {
    tracked.path_break->to_scan = so_far_.track.size() - 1;
    so_far_.breaks.push_back(*tracked.path_break);
  }
  tell(tracked);
  if (tracked.path_break && tracked.path_break->cause == BreakCause::kCarried) place_lost();
  so_far_.lost_scans = tracked.left_out ? so_far_.lost_scans + 1 : 0;
  so_far_.statistics.front_end_s += watch.seconds();
  take_out(tracked.taken_out, scan);
  hand_over(std::move(scan), robot_T_lidar, std::move(tracked));
}

/// Odometry that is found late is read later from then on, as its clock runs.
void Mapper::Impl::keep_odometry_in_time() {
  if (options_.front_end.odometry == OdometryUse::kTrust) return;
  const auto lag_s = front_end_.odometry_check().lag_s();
  if (lag_s && !scan_queue_.shift_odometry(Duration::from_seconds(*lag_s))) return;
  if (lag_s || scan_queue_.is_shifting()) front_end_.forget_lag();
}

void Mapper::Impl::begin_drive() {
  scan_queue_.finish();
  work_on_scans();
  if (so_far_.track.empty()) {
    scan_queue_ = ScanQueue(robot_.wheels);
    return;
  }
  back_end_.add_submaps(front_end_.begin_drive());
  scan_queue_ = ScanQueue(robot_.wheels);
  odom_frame_ = {};
  so_far_.lost_scans = 0;
  // One without scans is none.
  if (so_far_.drive_begins) so_far_.drives.pop_back();
  double most_x = 0.0;
  for (const TrackedPose& pose : so_far_.track) most_x = std::max(most_x, pose.local_T_robot.x);
  so_far_.drives.push_back(
      {.first_scan = so_far_.track.size(), .local_T_drive = {most_x + kMapper.beside_m, 0.0, 0.0}});
  so_far_.drive_begins = true;
}

/// Other drives have other clocks: the newest one begins some time after the one before ended.
SensorMessage Mapper::Impl::on_maps_clock(SensorMessage message) {
  std::optional<std::int64_t>& shift_ns = so_far_.drives.back().clock_shift_ns;
  if (!shift_ns) {
    const Stamp begins =
        so_far_.track.back().stamp + Duration::from_seconds(kMapper.between_drives_s);
    shift_ns = (begins - stamp_of(message)).nanoseconds;
  }
  std::visit([&](auto& known) { known.stamp = known.stamp + Duration{*shift_ns}; }, message);
  return message;
}

/// Its front end knows of no drive before it.
void Mapper::Impl::lay_beside(TrackedScan& tracked) const {
  const Pose2& local_T_drive = so_far_.drives.back().local_T_drive;
  tracked.local_T_robot = local_T_drive * tracked.local_T_robot;
  tracked.guess_local_T_robot = local_T_drive * tracked.guess_local_T_robot;
}

/// It may have begun anywhere on the map so far, facing anywhere.
PathBreak Mapper::Impl::break_before_drive(Stamp to) const {
  const Eigen::Vector2d from = so_far_.drives.back().local_T_drive.translation();
  double sigma_m = kMapper.beside_m;
  for (const TrackedPose& pose : so_far_.track)
    sigma_m = std::max(sigma_m, (pose.local_T_robot.translation() - from).norm());
  return {.from = so_far_.track.back().stamp,
          .to = to,
          .cause = BreakCause::kNewDrive,
          .bridge = BreakBridge::kNothing,
          .covariance = planar_covariance(sigma_m, kPi)};
}

void Mapper::Impl::count_scan(const TrackedScan& tracked) {
  if (!tracked.used) ++so_far_.statistics.scans_dropped;
  if (tracked.searched) ++so_far_.statistics.searches;
  if (tracked.key) ++so_far_.statistics.key_scans;
  if (!so_far_.track.empty() && tracked.status == MatchStatus::kDegenerate) {
    const Pose2 motion = so_far_.track.back().local_T_robot.inverse() * tracked.local_T_robot;
    so_far_.statistics.degenerate_travel_m += hypotenuse(motion.x, motion.y);
  }
}

/// The robot was set down some scans before the newest, by which it was found: they stand where
/// odometry says from there.
void Mapper::Impl::place_lost() {
  const TrackedPose& found = so_far_.track.back();
  for (std::int64_t back = 1; back <= so_far_.lost_scans; ++back) {
    TrackedPose& lost = so_far_.track[so_far_.track.size() - 1 - static_cast<std::size_t>(back)];
    if (!found.odom_T_robot || !lost.odom_T_robot) return;
    lost.local_T_robot = found.local_T_robot * (found.odom_T_robot->inverse() * *lost.odom_T_robot);
  }
}

/// An update of the newest scan, for whoever drives by it.
void Mapper::Impl::tell(const TrackedScan& tracked) {
  const bool may_jump = tracked.searched || tracked.path_break || so_far_.lost_scans > 0;
  MapUpdate update;
  update.stamp = so_far_.track.back().stamp;
  update.scan = scans() - 1;
  update.odom_T_robot =
      odom_frame_.follow(tracked.local_T_robot, tracked.guess_local_T_robot, may_jump);
  const Pose2 map_T_local = board_.map_T_local();
  update.map_T_odom = map_T_local * odom_frame_.local_T_odom();
  const bool is_guessed = tracked.path_break && tracked.path_break->bridge != BreakBridge::kLaser;
  update.covariance = rotated(is_guessed ? tracked.path_break->covariance : tracked.covariance,
                              map_T_local.rotation());
  update.status = tracked.tracking;
  if (update.status == TrackingStatus::kDegenerate)
    update.open_direction_rad = open_direction(update.covariance);
  if (tracked.key) update.key_scan = static_cast<std::size_t>(so_far_.statistics.key_scans - 1);
  update.events = events_of(tracked);
  if (updates_.size() == kMapper.updates_most) {
    updates_.pop_front();
    ++updates_missed_;
  }
  updates_.push_back(std::move(update));
}

std::vector<MapEvent> Mapper::Impl::events_of(const TrackedScan& tracked) {
  std::vector<MapEvent> events =
      fault_events_.changes(front_end_.odometry_check(), front_end_.laser_check());
  if (tracked.path_break) events.emplace_back(PathBroken{*tracked.path_break});
  if (!events.empty() || so_far_.track.size() == 1) put_up_faults();
  for (std::size_t i = 0; i < tracked.finished.size(); ++i)
    events.emplace_back(SubmapFrozen{{so_far_.submaps_frozen++}});
  if (tracked.starts_submap) events.emplace_back(SubmapOpened{{so_far_.submaps_opened++}});
  for (MapEvent& event : board_.take_events()) events.push_back(std::move(event));
  return events;
}

void Mapper::Impl::put_up_faults() {
  board_.set_faults({.first_scan = so_far_.track.front().stamp,
                     .odometry = front_end_.odometry_check().episodes(),
                     .laser = front_end_.laser_check().episodes(),
                     .breaks = so_far_.breaks});
}

/// Gives the back end what the front end is done with.
void Mapper::Impl::hand_over(LaserScan scan, const Pose2& robot_T_lidar, TrackedScan tracked) {
  const std::size_t index = so_far_.track.size() - 1;
  const Pose2& local_T_robot = tracked.local_T_robot;
  std::optional<KeyScan> key;
  if (tracked.key) {
    key = {scan.stamp, local_T_robot, tracked.covariance, index, tracked.starts_submap};
    if (tracked.path_break && tracked.path_break->bridge != BreakBridge::kLaser)
      key->across = tracked.path_break->covariance;
    key->starts_drive = tracked.path_break && tracked.path_break->cause == BreakCause::kNewDrive;
  }
  // Standing still adds nothing to the map, and a fast scanner no more than a slow one.
  const Pose2 since = so_far_.last_mapped.inverse() * local_T_robot;
  const bool moved =
      hypotenuse(since.x, since.y) > kMapper.still_cells * options_.map.resolution_m ||
      std::abs(since.yaw) > kMapper.still_rad;
  if (key || (tracked.used && !tracked.left_out && moved)) {
    so_far_.last_mapped = local_T_robot;
    const Pose2 end = end_of_sweep(scan, local_T_robot);
    back_end_.add_scan({std::move(scan), index, robot_T_lidar, local_T_robot, end, key.has_value()},
                       key);
  }
  back_end_.add_submaps(std::move(tracked.finished));
}

/// Where the robot is when the sweep of the newest scan ends, if it goes on as it came.
Pose2 Mapper::Impl::end_of_sweep(const LaserScan& scan, const Pose2& local_T_robot) const {
  const double sweep_s = sweep_seconds(scan);
  const bool is_first_of_drive =
      !so_far_.drives.empty() && so_far_.track.size() == so_far_.drives.back().first_scan + 1;
  if (so_far_.track.size() < 2 || is_first_of_drive || sweep_s == 0.0) return local_T_robot;
  const TrackedPose& before = so_far_.track[so_far_.track.size() - 2];
  const double share = sweep_s / seconds_between_scans(before.stamp, scan);
  const Pose2 motion = before.local_T_robot.inverse() * local_T_robot;
  return local_T_robot * exp(Tangent2(log(motion) * share));
}

std::future<MapperState> Mapper::Impl::save_state() {
  return back_end_.add_state({.scan_queue = scan_queue_.state(),
                              .front_end = front_end_.state(),
                              .so_far = so_far_,
                              .odom_frame = odom_frame_.state()});
}

void Mapper::Impl::restore_state(MapperState state) {
  const double reach_m = options_.front_end.range_max_m + kMapper.submap_travel_most_m;
  require_sound(is_sound(state, reach_m), "a map that contradicts itself");
  scan_queue_.restore(std::move(state.scan_queue));
  front_end_.restore(std::move(state.front_end));
  require_sound(front_end_.submaps_lie_within(reach_m), "a submap larger than the laser reaches");
  so_far_ = std::move(state.so_far);
  odom_frame_.restore(state.odom_frame);
  back_end_.restore(std::move(state.back_end), std::move(state.waiting));
  // What was told before the run was broken off is not told again.
  (void)fault_events_.changes(front_end_.odometry_check(), front_end_.laser_check());
  if (!so_far_.track.empty()) put_up_faults();
}

/// Works on the scans that still wait for odometry, and closes the open submaps.
void Mapper::Impl::end_log() {
  if (std::exchange(log_ended_, true)) return;
  scan_queue_.finish();
  work_on_scans();
  back_end_.add_submaps(front_end_.finish());
}

/// The log may end while the laser does not hold the pose.
std::optional<PathBreak> Mapper::Impl::break_in_the_end() const {
  if (so_far_.track.empty()) return {};
  const Stamp last = so_far_.track.back().stamp;
  auto open_end = front_end_.break_in_the_end(last, scan_queue_.reading_at(last));
  if (open_end) open_end->to_scan = so_far_.track.size();
  return open_end;
}

Calibration Mapper::Impl::judge_robot() {
  end_log();
  back_end_.wait();
  MapResult so_far;
  so_far.breaks = so_far_.breaks;
  report_sensors(front_end_, scan_queue_, so_far);
  find_calibration(back_end_.back_end().chain(), so_far_.track, robot_, options_, so_far);
  return so_far.calibration;
}

/// Ends the log and closes the last loops. What it tells is taken from here.
SettledMap Mapper::Impl::settle(const std::function<bool()>& goes_on) {
  end_log();
  back_end_.finish(goes_on);
  SettledMap map{.robot = robot_, .options = options_, .has_gyro = so_far_.gyro_scans > 0};
  MapStatistics& statistics = map.counted.statistics;
  statistics = so_far_.statistics;
  statistics.scans = scans();
  report_sensors(front_end_, scan_queue_, map.counted);
  map.counted.breaks = so_far_.breaks;
  if (auto open_end = break_in_the_end()) map.counted.breaks.push_back(*open_end);
  map.counted.drives = so_far_.drives;
  const BackEnd& back_end = back_end_.back_end();
  statistics.path_length_m = back_end.path_length_m();
  statistics.submaps = static_cast<std::int64_t>(back_end.submap_count());
  statistics.loop_closing_s = back_end.loop_closing_s();
  statistics.optimisation_s = back_end.optimisation_s();
  map.settled = {back_end.graph(), back_end.closures()};
  map.chain = back_end.chain();
  map.track = std::exchange(so_far_.track, {});
  return map;
}

MapResult Mapper::Impl::finish(const ProgressCallback& progress, const std::stop_token& cancel) {
  bool complete = true;
  const auto goes_on_to = [&](int stage) {
    if (complete &&
        (cancel.stop_requested() || (progress && !progress({"finishing", stage, kFinishStages}))))
      complete = false;
    return complete;
  };
  SettledMap map = settle([&] { return goes_on_to(0); });
  // An interrupted search for loops is the end of all that only refines and judges.
  const FinishCalls calls{.goes_on_to = goes_on_to,
                          .addition = complete ? addition_ : GraphAddition{},
                          .track_is_told = [&] { map.track = {}; }};
  MapResult result = finish_settled(map, std::exchange(map.settled, {}), calls, threads_);
  result.complete = complete;
  return result;
}

Mapper::Mapper(const RobotModel& robot, const MapOptions& options, Threads threads)
    : impl_((require_valid(options), std::make_unique<Impl>(robot, options, threads))) {}
Mapper::~Mapper() = default;

void Mapper::add(const SensorMessage& message) { impl_->add(message); }
std::optional<MapUpdate> Mapper::next_update() { return impl_->next_update(); }
void Mapper::begin_drive() { impl_->begin_drive(); }
Calibration Mapper::judge_robot() { return impl_->judge_robot(); }
MapSnapshot Mapper::snapshot() const { return impl_->snapshot(); }
MapResult Mapper::finish(const ProgressCallback& progress, const std::stop_token& cancel) {
  return impl_->finish(progress, cancel);
}
SettledMap Mapper::settle(const std::function<bool()>& goes_on) { return impl_->settle(goes_on); }
void Mapper::set_graph_addition(GraphAddition addition) {
  impl_->set_graph_addition(std::move(addition));
}
std::future<MapperState> Mapper::save_state() { return impl_->save_state(); }
void Mapper::restore_state(MapperState state) { impl_->restore_state(std::move(state)); }
std::int64_t Mapper::scans() const { return impl_->scans(); }

}  // namespace loopstone
