#include "loopstone/slam/mapper.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "loopstone/sensor/scan_points.hpp"
#include "loopstone/slam/back_end.hpp"
#include "loopstone/slam/surface_adjustment.hpp"
#include "slam/odometry_warnings.hpp"
#include "slam/stopwatch.hpp"
#include "slam/task_queue.hpp"

namespace loopstone {

namespace {

/// Scans that differ less than this from the last one mapped add next to nothing to the final map.
constexpr double kStillCells = 1.0;
constexpr double kStillRad = 0.04;

/// What the user should know about the run, in plain words.
std::vector<std::string> warnings_of(const MapResult& result, const MapOptions& options,
                                     bool has_gyro) {
  const MapStatistics& s = result.statistics;
  std::vector<std::string> warnings;
  const auto share = [&](std::int64_t count) {
    return std::to_string(count) + " of " + std::to_string(s.scans) + " scans";
  };
  const bool ignored = options.front_end.odometry == "ignore";
  if (s.scans > 0 && (ignored || result.odometry.empty())) {
    const std::string none =
        ignored ? "odometry was left out as asked: " : "no odometry in the log: ";
    warnings.push_back(none + (has_gyro && !ignored
                                   ? "the gyro tells the heading, distances are guessed"
                                   : "the motion between scans is guessed from the last one"));
  }
  if (s.scans_dropped > 0) {
    warnings.push_back(share(s.scans_dropped) +
                       " had too few returns to be used; odometry bridged them");
  }
  if (s.searches * 50 > s.scans) {
    warnings.push_back(share(s.searches) +
                       " fitted so badly that a search had to check them; look for places where "
                       "the map is blurred");
  }
  if (s.degenerate_travel_m > 0.05 * s.path_length_m && s.degenerate_travel_m > 1.0) {
    warnings.push_back(std::to_string(std::lround(s.degenerate_travel_m)) +
                       " m of the path ran where the laser leaves one direction open (corridors); "
                       "there the map is as long as odometry says");
  }
  if (options.loop_closure && s.loop_closures_accepted == 0 && s.path_length_m > 30.0) {
    warnings.emplace_back("no place was recognised a second time: drift was not corrected");
  }
  return warnings;
}

}  // namespace

/// The back end, fed through a queue so that it runs beside the front end when there is more than one thread.
class Mapper::BackEndWorker {
 public:
  BackEndWorker(const MapOptions& options, Threads threads)
      : back_end_(options, threads), queue_(threads.resolved() > 1) {}

  void add_key(const KeyScan& key) {
    queue_.run([this, key] { back_end_.add_key(key); });
  }
  void add_submap(FinishedSubmap submap) {
    auto shared = std::make_shared<FinishedSubmap>(std::move(submap));
    queue_.run([this, shared] { back_end_.add_submap(std::move(*shared)); });
  }
  /// Waits for all that was queued, ends the back end and gives access to it.
  [[nodiscard]] const BackEnd& finish() {
    queue_.run([this] { back_end_.finish(); });
    queue_.wait();
    return back_end_;
  }

 private:
  BackEnd back_end_;
  TaskQueue queue_;
};

Mapper::Mapper(const RobotModel& robot, const MapOptions& options, Threads threads)
    : robot_(robot),
      options_(options),
      threads_(threads),
      scan_queue_(robot.wheels),
      front_end_(options.front_end, options.match, options.submap),
      back_end_(std::make_unique<BackEndWorker>(options, threads)) {}

Mapper::~Mapper() = default;

void Mapper::add(const SensorMessage& message) {
  scan_queue_.add(message);
  while (auto scan = scan_queue_.next()) add_scan(std::move(*scan));
}

void Mapper::add_scan(LaserScan scan) {
  const Stopwatch watch;
  const Pose2 robot_T_lidar = mount_of(scan, robot_);
  const auto odometry = scan_queue_.reading_at(scan.stamp);
  std::optional<Pose2> odom_T_robot;
  if (odometry && odometry->has_translation) odom_T_robot = odometry->odom_T_robot;
  if (odometry && !odometry->has_translation) ++gyro_scans_;

  TrackedScan tracked = front_end_.add(scan, robot_T_lidar, odometry);
  if (!tracked.used) ++statistics_.scans_dropped;
  if (tracked.searched) ++statistics_.searches;

  ScanRecord record{.scan = std::move(scan),
                    .robot_T_lidar = robot_T_lidar,
                    .local_T_robot = tracked.local_T_robot,
                    .local_T_robot_end = tracked.local_T_robot,
                    .odom_T_robot = odom_T_robot};
  const double sweep_s =
      record.scan.time_increment_s * static_cast<double>(record.scan.ranges_m.size());
  if (!records_.empty()) {
    const ScanRecord& before = records_.back();
    const Pose2 motion = before.local_T_robot.inverse() * tracked.local_T_robot;
    const double distance = std::hypot(motion.x, motion.y);
    if (tracked.status == MatchStatus::kDegenerate) statistics_.degenerate_travel_m += distance;
    const double seconds = (record.scan.stamp - before.scan.stamp).seconds();
    if (sweep_s != 0.0 && seconds > 0.0) {
      record.local_T_robot_end =
          tracked.local_T_robot * exp(Tangent2(log(motion) * (sweep_s / seconds)));
    }
  }
  // With one thread the back end works within the calls below.
  statistics_.front_end_s += watch.seconds();
  if (tracked.key) {
    back_end_->add_key({record.scan.stamp, tracked.local_T_robot, tracked.covariance});
    key_stamps_.push_back(record.scan.stamp);
  }
  for (auto& submap : tracked.finished) back_end_->add_submap(std::move(submap));

  // Standing still adds nothing to the map, and a fast scanner no more than a slow one.
  const Pose2 since = last_mapped_.inverse() * tracked.local_T_robot;
  record.mapped =
      tracked.used && !tracked.left_out &&
      (tracked.key || std::hypot(since.x, since.y) > kStillCells * options_.map.resolution_m ||
       std::abs(since.yaw) > kStillRad);
  if (record.mapped) {
    last_mapped_ = tracked.local_T_robot;
  } else {
    record.scan.ranges_m = {};
  }
  record.last_key = key_stamps_.empty() ? 0 : key_stamps_.size() - 1;
  records_.push_back(std::move(record));
}

std::vector<std::vector<SurfacePoint>> Mapper::key_surfaces() const {
  std::vector<std::vector<SurfacePoint>> surfaces;
  BeamTable beams;
  const SurfaceOptions options{.range_max_m = options_.front_end.range_max_m,
                               .points_max = options_.adjustment.points_max};
  for (std::size_t i = 0; i < records_.size() && surfaces.size() < key_stamps_.size(); ++i) {
    const ScanRecord& record = records_[i];
    if (record.scan.stamp != key_stamps_[surfaces.size()] || record.last_key != surfaces.size())
      continue;
    const double sweep_s =
        record.scan.time_increment_s * static_cast<double>(record.scan.ranges_m.size());
    Tangent2 velocity = Tangent2::Zero();
    if (sweep_s != 0.0) {
      velocity = log(record.local_T_robot.inverse() * record.local_T_robot_end) / sweep_s;
    }
    surfaces.push_back(surface_points(record.scan, record.robot_T_lidar, velocity, options, beams));
  }
  return surfaces;
}

/// How odometry fared beside the laser.
void Mapper::report_odometry(MapResult& result) const {
  const OdometryCheck& check = front_end_.odometry_check();
  MapStatistics& statistics = result.statistics;
  result.odometry_episodes = check.episodes();
  statistics.odometry_jumps = check.translation().jumps() + check.rotation().jumps();
  statistics.odometry_translation_scale = check.translation().scale().value_or(0.0);
  statistics.odometry_rotation_scale = check.rotation().scale().value_or(0.0);
  statistics.odometry_distrusted_s = check.distrusted_s();
}

/// Moves all key scans onto the surfaces that they share.
void Mapper::adjust(MapResult& result) const {
  if (!options_.adjustment.enabled) return;
  const Stopwatch watch;
  auto adjusted = adjust_to_surfaces(result.graph, key_surfaces(), options_.adjustment, threads_);
  result.graph.poses = std::move(adjusted.poses);
  result.statistics.surface_spread_before_m = adjusted.spread_before_m;
  result.statistics.surface_spread_m = adjusted.spread_after_m;
  result.statistics.adjustment_s = watch.seconds();
}

/// Puts every scan on the map. Scans between two key scans share the correction of both, blended by time.
/// Returns those that the map is drawn from.
std::vector<PosedScan> Mapper::place_scans(MapResult& result) const {
  std::vector<Pose2> map_T_local;
  for (std::size_t i = 0, key = 0; i < records_.size() && key < key_stamps_.size(); ++i) {
    if (records_[i].scan.stamp != key_stamps_[key] || records_[i].last_key != key) continue;
    map_T_local.push_back(result.graph.poses[key] * records_[i].local_T_robot.inverse());
    ++key;
  }
  std::vector<PosedScan> posed;
  for (const ScanRecord& record : records_) {
    Pose2 correction;
    if (!map_T_local.empty()) {
      const std::size_t key = record.last_key;
      correction = map_T_local[key];
      if (key + 1 < map_T_local.size() && record.scan.stamp > key_stamps_[key]) {
        const double ratio = (record.scan.stamp - key_stamps_[key]).seconds() /
                             (key_stamps_[key + 1] - key_stamps_[key]).seconds();
        const Pose2 first = map_T_local[key] * record.local_T_robot;
        const Pose2 second = map_T_local[key + 1] * record.local_T_robot;
        correction = interpolate(first, second, ratio) * record.local_T_robot.inverse();
      }
    }
    const Pose2 map_T_robot = correction * record.local_T_robot;
    result.trajectory.append(record.scan.stamp, map_T_robot);
    if (record.odom_T_robot) result.odometry.append(record.scan.stamp, *record.odom_T_robot);
    if (record.mapped) {
      posed.push_back({&record.scan, map_T_robot * record.robot_T_lidar,
                       correction * record.local_T_robot_end * record.robot_T_lidar, map_T_robot});
    }
  }
  return posed;
}

/// The figures that follow from the finished trajectory and graph.
void Mapper::count(MapResult& result) const {
  auto& statistics = result.statistics;
  statistics.scans = static_cast<std::int64_t>(records_.size());
  statistics.key_scans = static_cast<std::int64_t>(key_stamps_.size());
  for (const auto& closure : result.loop_closures) {
    ++(closure.accepted ? statistics.loop_closures_accepted : statistics.loop_closures_rejected);
  }
  if (!result.trajectory.empty()) {
    statistics.duration_s =
        (result.trajectory.back().stamp - result.trajectory.front().stamp).seconds();
  }
  // From key scan to key scan: between them the robot only trembles.
  const auto& poses = result.graph.poses;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    statistics.path_length_m +=
        std::hypot(poses[i].x - poses[i - 1].x, poses[i].y - poses[i - 1].y);
  }
  statistics.graph_cost = graph_cost(result.graph);
}

MapResult Mapper::finish() {
  scan_queue_.finish();
  while (auto scan = scan_queue_.next()) add_scan(std::move(*scan));
  for (auto& submap : front_end_.finish()) back_end_->add_submap(std::move(submap));
  const BackEnd& back_end = back_end_->finish();

  MapResult result;
  result.node_stamps = key_stamps_;
  result.graph = back_end.graph();
  result.loop_closures = back_end.closures();
  result.statistics = statistics_;
  auto& statistics = result.statistics;
  statistics.submaps = static_cast<std::int64_t>(back_end.submap_count());
  statistics.loop_closing_s = back_end.loop_closing_s();
  statistics.optimisation_s = back_end.optimisation_s();
  report_odometry(result);

  // The graph's own solution is judged: the adjustment knows more than its edges.
  const Stopwatch judging_graph;
  result.graph_quality = assess_graph(result);
  statistics.judging_s = judging_graph.seconds();
  adjust(result);
  const std::vector<PosedScan> posed = place_scans(result);

  const Stopwatch rendering;
  result.map = build_occupancy_map(posed, robot_.footprint_radius_m, options_.map, threads_);
  statistics.rendering_s = rendering.seconds();
  count(result);

  const Stopwatch judging;
  result.quality = assess_map(posed, threads_);
  result.verdict = judge_map(result);
  statistics.judging_s += judging.seconds();
  result.warnings = warnings_of(result, options_, gyro_scans_ > 0);
  const auto of_odometry = odometry_warnings(result);
  result.warnings.insert(result.warnings.begin(), of_odometry.begin(), of_odometry.end());
  return result;
}

}  // namespace loopstone
