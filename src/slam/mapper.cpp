#include "loopstone/slam/mapper.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <exception>
#include <functional>
#include <optional>
#include <string_view>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/base/release_memory.hpp"
#include "loopstone/sensor/scan_points.hpp"
#include "loopstone/slam/back_end.hpp"
#include "loopstone/slam/surface_adjustment.hpp"
#include "slam/break_warnings.hpp"
#include "slam/drift_correction.hpp"
#include "slam/odometry_warnings.hpp"
#include "slam/scan_store.hpp"
#include "slam/sensor_faults.hpp"
#include "slam/stopwatch.hpp"
#include "slam/task_queue.hpp"

namespace loopstone {

namespace {

/// Scans that differ less than this from the last one mapped add next to nothing to the final map.
constexpr double kStillCells = 1.0;
constexpr double kStillRad = 0.04;

/// From a submap's origin its robot is never farther.
constexpr double kMostSubmapTravelM = 300.0;

/// Raised whenever a field list of that part changes.
constexpr std::uint16_t kScanQueueVersion = 2;
constexpr std::uint16_t kFrontEndVersion = 2;
constexpr std::uint16_t kBackEndVersion = 3;
constexpr std::uint16_t kMapperVersion = 2;

/// Who interrupts a run does not wait for the map of all scans; one of these is drawn in half a second and shows every wall.
constexpr std::size_t kMostScansInterrupted = 4000;

void thin(std::vector<PosedScan>& scans) {
  const std::size_t step = scans.size() / kMostScansInterrupted + 1;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < scans.size(); i += step) scans[kept++] = scans[i];
  scans.resize(kept);
}

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
  if (auto coarser = coarser_than_asked(result.map, options.map)) {
    warnings.push_back(std::move(*coarser));
  }
  return warnings;
}

}  // namespace

/// The back end and the scans that it decides about, fed through a queue so that both run beside the front end when there is
/// more than one thread.
class Mapper::BackEndWorker {
 public:
  BackEndWorker(const MapOptions& options, Threads threads)
      : back_end_(options, threads), queue_(threads.resolved() > 1) {}

  void add_scan(MappedScan scan, const std::optional<KeyScan>& key) {
    // Handed over with the next submap: a thread that wakes for every scan costs more than it does.
    waiting_.push_back({std::move(scan), key});
  }
  void add_submaps(std::vector<FinishedSubmap> submaps) {
    if (submaps.empty()) return;
    auto batch = std::make_shared<Batch>(Batch{std::exchange(waiting_, {}), std::move(submaps)});
    queue_.run([this, batch] { take(std::move(*batch)); });
  }
  /// These chunks, and what the back end and its scans are after all that was handed over until now.
  [[nodiscard]] std::future<std::vector<StateChunk>> add_state(std::vector<StateChunk> chunks) {
    auto promise = std::make_shared<std::promise<std::vector<StateChunk>>>();
    auto saved = std::make_shared<std::vector<StateChunk>>(std::move(chunks));
    saved->push_back(save_chunk("WAIT", kBackEndVersion, waiting_));
    queue_.run([this, promise, saved] {
      saved->push_back(save_chunk("BACK", kBackEndVersion, back_end_));
      saved->push_back(save_chunk("MAPD", kBackEndVersion, scans_));
      promise->set_value(std::move(*saved));
    });
    return promise->get_future();
  }
  void restore(std::span<const StateChunk> chunks) {
    load_chunk(chunks, "WAIT", kBackEndVersion, waiting_);
    queue_.run([this, chunks] {
      load_chunk(chunks, "BACK", kBackEndVersion, back_end_);
      load_chunk(chunks, "MAPD", kBackEndVersion, scans_);
    });
    queue_.wait();
  }
  /// After restore(): whether the scans are those of the key scans, and all among the first `scans`.
  [[nodiscard]] bool scans_fit(std::size_t scans) const {
    if (scans_.stretch_count() != back_end_.stretch_count()) return false;
    const std::vector<KeyScan> keys = back_end_.keys();
    std::size_t key = 0;
    std::optional<std::size_t> last;
    bool in_order = true;
    const auto take = [&](std::size_t index) {
      in_order = in_order && index < scans && (!last || index > *last);
      last = index;
    };
    scans_.for_each([&](const MappedScan& mapped) {
      take(mapped.index);
      if (key < keys.size() && keys[key].scan == mapped.index) ++key;
    });
    for (const Step& step : waiting_) {
      take(step.scan.index);
      in_order = in_order && (!step.key || step.key->scan == step.scan.index);
    }
    return in_order && key == keys.size();
  }
  /// Waits for all that was handed over and ends the back end.
  /// \param goes_on  asked from the queue's thread
  void finish(const std::function<bool()>& goes_on) {
    auto batch = std::make_shared<Batch>(Batch{std::exchange(waiting_, {}), {}});
    queue_.run([this, batch, &goes_on] {
      take(std::move(*batch));
      back_end_.finish(goes_on);
    });
    queue_.wait();
  }
  /// After finish().
  [[nodiscard]] const BackEnd& back_end() const { return back_end_; }
  [[nodiscard]] const ScanStore& scans() const { return scans_; }

 private:
  struct Step {
    MappedScan scan{};
    std::optional<KeyScan> key{};

    template <typename Archive>
    void archive(Archive& a) {
      a(scan, key);
    }
  };
  struct Batch {
    std::vector<Step> steps{};
    std::vector<FinishedSubmap> submaps{};
  };

  void take(Batch batch) {
    for (Step& step : batch.steps) {
      if (step.key) back_end_.add_key(*step.key);
      scans_.add(std::move(step.scan), step.key && step.key->starts_submap);
    }
    for (FinishedSubmap& submap : batch.submaps) back_end_.add_submap(std::move(submap));
    for (const std::size_t stretch : back_end_.take_thinned()) scans_.thin(stretch);
  }

  BackEnd back_end_;
  ScanStore scans_{};
  std::vector<Step> waiting_{};
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

std::future<std::vector<StateChunk>> Mapper::save_state() {
  std::vector<StateChunk> chunks;
  chunks.push_back(save_chunk("SCAN", kScanQueueVersion, scan_queue_));
  chunks.push_back(save_chunk("FRNT", kFrontEndVersion, front_end_));
  chunks.push_back(save_chunk("MAPR", kMapperVersion, *this));
  return back_end_->add_state(std::move(chunks));
}

void Mapper::restore_state(std::span<const StateChunk> chunks) {
  constexpr std::array<std::string_view, 6> kTags{"SCAN", "FRNT", "MAPR", "WAIT", "BACK", "MAPD"};
  refuse_unknown(chunks, kTags);
  load_chunk(chunks, "SCAN", kScanQueueVersion, scan_queue_);
  load_chunk(chunks, "FRNT", kFrontEndVersion, front_end_);
  load_chunk(chunks, "MAPR", kMapperVersion, *this);
  back_end_->restore(chunks);
  if (!back_end_->scans_fit(track_.size())) {
    throw DataError({chunks.front().origin.path}, "damaged: scans that contradict the path");
  }
  const double reach_m = options_.front_end.range_max_m + kMostSubmapTravelM;
  if (!front_end_.submaps_lie_within(reach_m) ||
      !back_end_->back_end().submaps_lie_within(reach_m)) {
    throw DataError({chunks.front().origin.path},
                    "damaged: a submap larger than the laser reaches");
  }
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

  if (!track_.empty() && tracked.status == MatchStatus::kDegenerate) {
    const Pose2 motion = track_.back().local_T_robot.inverse() * tracked.local_T_robot;
    statistics_.degenerate_travel_m += std::hypot(motion.x, motion.y);
  }
  track_.push_back({scan.stamp, tracked.local_T_robot, odom_T_robot});
  if (tracked.path_break) {
    breaks_.push_back(*tracked.path_break);
    breaks_.back().to_scan = track_.size() - 1;
  }
  // With one thread the back end works within the call below.
  statistics_.front_end_s += watch.seconds();
  hand_over(std::move(scan), robot_T_lidar, std::move(tracked));
}

/// Where the robot is when the sweep of the newest scan ends, if it goes on as it came.
Pose2 Mapper::end_of_sweep(const LaserScan& scan, const Pose2& local_T_robot) const {
  const double sweep_s = sweep_seconds(scan);
  if (track_.size() < 2 || sweep_s == 0.0) return local_T_robot;
  const TrackedPose& before = track_[track_.size() - 2];
  const double seconds = (scan.stamp - before.stamp).seconds();
  if (!(seconds > 0.0)) return local_T_robot;
  const Pose2 motion = before.local_T_robot.inverse() * local_T_robot;
  return local_T_robot * exp(Tangent2(log(motion) * (sweep_s / seconds)));
}

/// Gives the back end what the front end is done with.
void Mapper::hand_over(LaserScan scan, const Pose2& robot_T_lidar, TrackedScan tracked) {
  const std::size_t index = track_.size() - 1;
  const Pose2& local_T_robot = tracked.local_T_robot;
  std::optional<KeyScan> key;
  if (tracked.key) {
    key = {scan.stamp, local_T_robot, tracked.covariance, index, tracked.starts_submap};
    if (tracked.path_break && tracked.path_break->bridge != BreakBridge::kLaser)
      key->across = tracked.path_break->covariance;
    ++statistics_.key_scans;
  }
  // Standing still adds nothing to the map, and a fast scanner no more than a slow one.
  const Pose2 since = last_mapped_.inverse() * local_T_robot;
  const bool moved = std::hypot(since.x, since.y) > kStillCells * options_.map.resolution_m ||
                     std::abs(since.yaw) > kStillRad;
  if (key || (tracked.used && !tracked.left_out && moved)) {
    last_mapped_ = local_T_robot;
    const Pose2 end = end_of_sweep(scan, local_T_robot);
    back_end_->add_scan({std::move(scan), index, robot_T_lidar, local_T_robot, end}, key);
  }
  back_end_->add_submaps(std::move(tracked.finished));
}

std::vector<std::vector<SurfacePoint>> Mapper::key_surfaces(std::span<const KeyScan> keys) const {
  std::vector<std::vector<SurfacePoint>> surfaces;
  surfaces.reserve(keys.size());
  BeamTable beams;
  const SurfaceOptions options{.range_max_m = options_.front_end.range_max_m,
                               .points_max = options_.adjustment.points_max};
  back_end_->scans().for_each([&](const MappedScan& mapped) {
    if (surfaces.size() == keys.size() || mapped.index != keys[surfaces.size()].scan) return;
    const double sweep_s = sweep_seconds(mapped.scan);
    Tangent2 velocity = Tangent2::Zero();
    if (sweep_s != 0.0)
      velocity = log(mapped.local_T_robot.inverse() * mapped.local_T_robot_end) / sweep_s;
    surfaces.push_back(surface_points(mapped.scan, mapped.robot_T_lidar, velocity, options, beams));
  });
  return surfaces;
}

/// How odometry fared beside the laser, and the laser by itself.
void Mapper::report_sensors(MapResult& result) const {
  result.statistics.laser_heading_offset_rad =
      front_end_.odometry_check().laser_heading_offset_rad();
  result.statistics.wheels_with_gyro = scan_queue_.odometer().wheels_with_gyro();
  result.laser_episodes = front_end_.laser_check().episodes();
  result.statistics.scans_repeated =
      static_cast<std::int64_t>(front_end_.laser_check().most_repeated());
  const OdometryCheck& check = front_end_.odometry_check();
  MapStatistics& statistics = result.statistics;
  result.odometry_episodes = check.episodes();
  statistics.odometry_jumps = check.translation().jumps() + check.rotation().jumps();
  statistics.odometry_translation_scale = check.translation().scale().value_or(0.0);
  statistics.odometry_rotation_scale = check.rotation().scale().value_or(0.0);
  statistics.odometry_distrusted_s = check.distrusted_s();
}

/// Moves all key scans onto the surfaces that they share.
void Mapper::adjust(std::span<const KeyScan> keys, MapResult& result) const {
  if (!options_.adjustment.enabled) return;
  const Stopwatch watch;
  auto adjusted =
      adjust_to_surfaces(result.graph, key_surfaces(keys), options_.adjustment, threads_);
  result.graph.poses = std::move(adjusted.poses);
  result.statistics.surface_spread_before_m = adjusted.spread_before_m;
  result.statistics.surface_spread_m = adjusted.spread_after_m;
  result.statistics.adjustment_s = watch.seconds();
}

/// Puts every scan on the map. Returns those that the map is drawn from.
std::vector<PosedScan> Mapper::place_scans(std::vector<KeyScan> keys, MapResult& result) const {
  const DriftCorrection correction(std::move(keys), result.graph.poses);
  result.trajectory.reserve(track_.size());
  result.odometry.reserve(track_.empty() || !track_.back().odom_T_robot ? 0 : track_.size());
  for (std::size_t i = 0; i < track_.size(); ++i) {
    const auto& [stamp, local_T_robot, odom_T_robot] = track_[i];
    result.trajectory.append(stamp, correction.at(i, stamp, local_T_robot) * local_T_robot);
    if (odom_T_robot) result.odometry.append(stamp, *odom_T_robot);
  }
  std::vector<PosedScan> posed;
  back_end_->scans().for_each([&](const MappedScan& mapped) {
    const Pose2 map_T_local = correction.at(mapped.index, mapped.scan.stamp, mapped.local_T_robot);
    const Pose2 map_T_robot = map_T_local * mapped.local_T_robot;
    posed.push_back({&mapped.scan, map_T_robot * mapped.robot_T_lidar,
                     map_T_local * mapped.local_T_robot_end * mapped.robot_T_lidar, map_T_robot});
  });
  return posed;
}

/// The figures that follow from the finished trajectory and graph.
void Mapper::count(MapResult& result) {
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

MapResult Mapper::finish(const ProgressCallback& progress) {
  constexpr std::int64_t kStages = 5;
  MapResult result;
  const auto goes_on_to = [&](std::int64_t stage) {
    if (result.complete && progress && !progress({"finishing", stage, kStages}))
      result.complete = false;
    return result.complete;
  };
  scan_queue_.finish();
  while (auto scan = scan_queue_.next()) add_scan(std::move(*scan));
  back_end_->add_submaps(front_end_.finish());
  back_end_->finish([&] { return goes_on_to(0); });
  const BackEnd& back_end = back_end_->back_end();
  std::vector<KeyScan> keys = back_end.keys();

  std::vector<std::size_t> node_scans;
  for (const KeyScan& key : keys) {
    result.node_stamps.push_back(key.stamp);
    node_scans.push_back(key.scan);
  }
  result.graph = back_end.graph();
  result.loop_closures = back_end.closures();
  result.statistics = statistics_;
  auto& statistics = result.statistics;
  statistics.scans = scans();
  statistics.key_scans_thinned = statistics.key_scans - static_cast<std::int64_t>(keys.size());
  statistics.path_length_m = back_end.path_length_m();
  statistics.submaps = static_cast<std::int64_t>(back_end.submap_count());
  statistics.loop_closing_s = back_end.loop_closing_s();
  statistics.optimisation_s = back_end.optimisation_s();
  report_sensors(result);
  result.breaks = breaks_;
  find_ties(result.breaks, result.graph, node_scans);

  release_unused_memory();
  // The graph's own solution is judged: the adjustment knows more than its edges.
  const Stopwatch judging_graph;
  if (goes_on_to(1)) result.graph_quality = assess_graph(result);
  statistics.judging_s = judging_graph.seconds();
  if (goes_on_to(2)) adjust(keys, result);
  std::vector<PosedScan> posed = place_scans(std::move(keys), result);
  track_ = {};  // it is in the trajectories now
  release_unused_memory();

  const Stopwatch rendering;
  if (!goes_on_to(3)) thin(posed);
  try {
    result.map = build_occupancy_map(posed, robot_.footprint_radius_m, options_.map, threads_);
  } catch (const std::exception& error) {
    result.map_failure = error.what();
  }
  statistics.rendering_s = rendering.seconds();
  count(result);

  release_unused_memory();
  const Stopwatch judging;
  if (goes_on_to(4) && result.map_failure.empty()) {
    result.quality = assess_map(posed, threads_);
    result.verdict = judge_map(result);
  }
  statistics.judging_s += judging.seconds();
  // What went wrong first, then how the run fared.
  for (auto& warnings : {break_warnings(result), sensor_faults(result), odometry_warnings(result),
                         warnings_of(result, options_, gyro_scans_ > 0)}) {
    result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
  }
  return result;
}

}  // namespace loopstone
