#include "loopstone/localization/landmark_tracker.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <utility>

#include "localization/belief_snapshots.hpp"
#include "localization/observation_window.hpp"
#include "localization/pose_evidence.hpp"
#include "localization/robot_motion.hpp"
#include "loopstone/base/option_list.hpp"
#include "loopstone/localization/constellation_search.hpp"
#include "loopstone/localization/filter_health.hpp"
#include "loopstone/localization/landmark_belief.hpp"
#include "loopstone/odometry/scan_queue.hpp"
#include "loopstone/sensor/mounted_scan.hpp"

namespace loopstone {
namespace {

/// A pose within so much of another is as right: what a probability is of.
constexpr double kRightM = 0.2;
constexpr double kRightRad = 5.0 * kPi / 180.0;
/// Errors of one reading are those of the next, too (a strip between two beams, an axle that
/// slips), which no covariance says: from reading to reading the robot strays a little more.
constexpr double kStrayM = 0.001;
constexpr double kStrayRad = 0.0002;
/// With more belief in the rest than this, it is worth a search.
constexpr double kWorthASearch = 0.01;
/// With more than this the robot is taken to be elsewhere.
constexpr double kLost = 0.5;
/// Between searches that found nothing.
constexpr Duration kSearchPause = Duration::from_milliseconds(500);
/// At the end readings so far beyond the last odometry are taken, as scans are.
constexpr Duration kPatience = Duration::from_milliseconds(kScanQueue.patience_ms);
/// Readings that contradict their predictions halve the probability, and so do too few of them
/// since the place was found: no more than DOUBTFUL.
constexpr double kUnsure = 0.5;
constexpr int kConfirmingReadings = 5;
/// A mean over the last readings: this share of it is the newest.
constexpr double kNewestShare = 0.2;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

PoseWithCovariance2 given(const InitialPose& initial) {
  PoseWithCovariance2 pose{.pose = initial.map_T_robot};
  pose.covariance.diagonal() << initial.sigma_m * initial.sigma_m,
      initial.sigma_m * initial.sigma_m, initial.sigma_rad * initial.sigma_rad;
  return pose;
}

}  // namespace

class LandmarkTracker::Impl {
 public:
  Impl(LandmarkMap map, const RobotModel& robot, const LandmarkTrackingOptions& options,
       const std::optional<InitialPose>& initial)
      : map_(std::move(map)),
        robot_(robot),
        options_(valid(options)),
        clutter_{.share = options.clutter_share, .max_range_m = options.max_range_m},
        index_(map_, options.max_range_m),
        belief_(map_, clutter_),
        queue_(robot.wheels),
        motion_(LocalizationOptions{}),
        snapshots_(options.snapshot_distance_m) {
    if (initial) belief_.start_at(given(*initial));
  }
  Impl(const Impl&) = delete;  // parts refer to the map
  Impl& operator=(const Impl&) = delete;

  void add(const SensorMessage& message) {
    const auto mounted = as_mounted(message, robot_);
    queue_.add(mounted ? *mounted : message);
    process_ready(false);
  }

  void add(const LandmarkReading& reading) {
    waiting_.push_back(reading);
    process_ready(false);
  }

  std::optional<LocalizationEstimate> next_update() {
    if (handed_out_ == result_.estimates.size()) return {};
    return result_.estimates[handed_out_++];
  }

  LocalizationResult finish() {
    queue_.finish();
    process_ready(true);
    if (motion_.first_stamp()) {
      result_.start = *motion_.first_stamp();
      result_.duration_s = (*motion_.last_stamp() - *motion_.first_stamp()).seconds();
    }
    result_.path_length_m = motion_.travelled_m();
    result_.had_odometry = motion_.had_odometry();
    result_.snapshots = snapshots_.take();
    if (result_.estimates.empty() && observations_ > 0) {
      result_.warnings.emplace_back(
          "no place among the landmarks explains what was seen: is it the map of this place, and "
          "are its landmarks where the map has them?");
    }
    if (!result_.had_odometry && result_.scans > 0) {
      result_.warnings.emplace_back(
          "the log has no odometry: the robot is assumed to keep its velocity from reading to "
          "reading");
    }
    return std::move(result_);
  }

  [[nodiscard]] std::int64_t scans_with_intensities() const { return with_intensities_; }
  [[nodiscard]] std::int64_t observations() const { return observations_; }

 private:
  static const LandmarkTrackingOptions& valid(const LandmarkTrackingOptions& options) {
    require_valid(options);
    return options;
  }

  void process_ready(bool all) {
    const auto start = std::chrono::steady_clock::now();
    const double searched_before = result_.search_s;
    while (const auto scan = queue_.next()) process(*scan);
    const auto known_until = queue_.odometer().newest();
    const auto is_ready = [&](Stamp stamp) {
      return known_until ? stamp <= *known_until + (all ? kPatience : Duration{}) : all;
    };
    while (!waiting_.empty() && is_ready(waiting_.front().stamp)) {
      process(waiting_.front());
      waiting_.pop_front();
    }
    result_.filter_s += seconds_since(start) - (result_.search_s - searched_before);
  }

  void process(const LaserScan& scan) {
    if (!advance(scan.stamp)) return;
    if (!scan.intensities.empty()) ++with_intensities_;
    take_in(find_reflectors(scan, mount_of(scan, robot_), motion_.velocity(), options_.reflectors));
  }

  void process(const LandmarkReading& reading) {
    if (advance(reading.stamp)) take_in(reading.observations);
  }

  /// Goes on to a reading's stamp; false when it is not newer than the last.
  bool advance(Stamp stamp) {
    if (motion_.last_stamp() && stamp <= *motion_.last_stamp()) return false;
    ++result_.scans;
    PoseWithCovariance2 motion = motion_.step_to(stamp, queue_.odometer());
    motion.covariance.diagonal() +=
        Eigen::Vector3d(kStrayM * kStrayM, kStrayM * kStrayM, kStrayRad * kStrayRad);
    odom_T_robot_ = odom_T_robot_ * motion.pose;
    belief_.predict(motion);
    window_.move(motion);
    return true;
  }

  void take_in(const std::vector<LandmarkObservation>& seen) {
    observations_ += static_cast<std::int64_t>(seen.size());
    if (seen.empty()) ++result_.scans_dropped;
    const double rest_before = belief_.rest();
    belief_.update(seen, window_.expectations(seen, clutter_.log_anywhere()));
    if (is_surprised(seen, rest_before)) window_.clear();
    window_.add(seen);
    if (!seen.empty()) search_if_worthwhile();
    if (belief_.places().empty()) return;
    check_predictions(seen);
    motion_.found_at(belief_.places().front().map_T_robot.pose);
    report(seen);
  }

  /// The robot seems to have been carried off just now: what was seen before is no part of the
  /// constellation that it sees now.
  [[nodiscard]] bool is_surprised(const std::vector<LandmarkObservation>& seen,
                                  double rest_before) const {
    if (belief_.places().empty()) return false;
    if (belief_.rest() > kLost && rest_before <= kLost) return true;
    const auto explained = static_cast<std::size_t>(belief_.places().front().explained);
    return seen.size() >= 2 && 2 * explained < seen.size();
  }

  void search_if_worthwhile() {
    const bool at_start = result_.searches.empty();
    const Stamp now = *motion_.last_stamp();
    if (belief_.rest() < kWorthASearch || window_.observations().size() < 2) return;
    if (!options_.recover && !(at_start && belief_.places().empty())) return;
    if (!at_start && now - result_.searches.back().stamp < kSearchPause) return;
    const auto start = std::chrono::steady_clock::now();
    const ConstellationSearch found = index_.search(window_.observations(), clutter_);
    LocalizationSearch record{.stamp = now, .whole_map = true};
    record.reason = at_start ? "start" : "lost";
    record.poses_found = static_cast<int>(found.matches.size());
    if (!found.matches.empty()) {
      record.best_score = static_cast<double>(found.matches.front().explained) /
                          static_cast<double>(window_.observations().size());
    }
    record.poses_added = belief_.add(found.matches);
    result_.searches.push_back(std::move(record));
    result_.search_s += seconds_since(start);
  }

  /// Whether the best place predicts what is seen, over the last readings.
  void check_predictions(const std::vector<LandmarkObservation>& seen) {
    const LandmarkPlace& best = belief_.places().front();
    if (best.id != best_id_) {
      best_id_ = best.id;
      best_since_m_ = motion_.travelled_m();
      health_.reset();
      explained_ = 1.0;
      return;  // the chi-square of a place just found is of the search
    }
    if (seen.empty()) return;
    const double share = static_cast<double>(best.explained) / static_cast<double>(seen.size());
    explained_ += kNewestShare * (share - explained_);
    if (best.explained > 0) {
      health_.add({.innovation_chi2 = best.chi2, .innovation_freedom = 2 * best.explained});
    }
  }

  void report(const std::vector<LandmarkObservation>& seen) {
    LocalizationEstimate estimate = estimate_now(!seen.empty());
    if (result_.changes.empty() || result_.changes.back().state != estimate.state)
      result_.changes.push_back({estimate.stamp, estimate.state});
    if (snapshots_.due(motion_.travelled_m()))
      snapshots_.add(snapshot_of(seen, estimate), motion_.travelled_m());
    result_.estimates.push_back(std::move(estimate));
  }

  [[nodiscard]] LocalizationEstimate estimate_now(bool seen) const {
    const LandmarkPlace& best = belief_.places().front();
    const FilterHealth health = health_.judge();
    LocalizationEstimate estimate;
    estimate.stamp = *motion_.last_stamp();
    estimate.map_T_robot = best.map_T_robot.pose;
    estimate.odom_T_robot = odom_T_robot_;
    estimate.covariance = best.map_T_robot.covariance;
    estimate.refined = seen && best.explained > 0;
    for (const LandmarkPlace& place : belief_.places())
      estimate.places.push_back({place.map_T_robot.pose, place.weight});
    estimate.hypotheses = static_cast<int>(estimate.places.size());
    estimate.landmarks = seen ? best.explained : 0;
    estimate.travelled_m = motion_.travelled_m();
    const Eigen::Matrix3d& spread = best.map_T_robot.covariance;
    estimate.evidence = {.explained = explained_,
                         .mass = belief_.mass_near(best.map_T_robot.pose, kRightM, kRightRad),
                         .precision = precision_of(best.map_T_robot.covariance),
                         .spread_m = std::sqrt(spread(0, 0) + spread(1, 1)),
                         .spread_rad = std::sqrt(spread(2, 2)),
                         .innovation = health.innovation_ratio,
                         .followed_m = motion_.travelled_m() - best_since_m_};
    const bool is_confirmed =
        health.doubt == FilterDoubt::kNone && health.readings >= kConfirmingReadings;
    const double of_place = estimate.evidence.mass * (is_confirmed ? 1.0 : kUnsure);
    estimate.probability = of_place * estimate.evidence.precision;
    estimate.state = estimate.probability >= options_.tracking_probability
                         ? LocalizationState::kTracking
                     : of_place < options_.lost_probability ? LocalizationState::kLost
                                                            : LocalizationState::kDoubtful;
    return estimate;
  }

  [[nodiscard]] BeliefSnapshot snapshot_of(const std::vector<LandmarkObservation>& seen,
                                           const LocalizationEstimate& estimate) const {
    BeliefSnapshot snapshot{.stamp = estimate.stamp, .estimate = estimate};
    snapshot.hypotheses = estimate.places;
    for (const LandmarkObservation& observation : seen) {
      snapshot.points.emplace_back(observation.point.cast<float>());
    }
    return snapshot;
  }

  LandmarkMap map_;
  RobotModel robot_;
  LandmarkTrackingOptions options_;
  ClutterModel clutter_;
  ConstellationIndex index_;
  LandmarkBelief belief_;
  ScanQueue queue_;
  RobotMotion motion_;
  BeliefSnapshots snapshots_;

  std::deque<LandmarkReading> waiting_{};
  ObservationWindow window_{};
  FilterHealthMonitor health_{};
  Pose2 odom_T_robot_{};
  int best_id_ = -1;
  double best_since_m_ = 0.0;
  double explained_ = 1.0;
  std::int64_t with_intensities_ = 0;
  std::int64_t observations_ = 0;
  LocalizationResult result_{};
  std::size_t handed_out_ = 0;
};

LandmarkTracker::LandmarkTracker(LandmarkMap map, const RobotModel& robot,
                                 const LandmarkTrackingOptions& options,
                                 const std::optional<InitialPose>& initial)
    : impl_(std::make_unique<Impl>(std::move(map), robot, options, initial)) {}
LandmarkTracker::~LandmarkTracker() = default;
LandmarkTracker::LandmarkTracker(LandmarkTracker&&) noexcept = default;
LandmarkTracker& LandmarkTracker::operator=(LandmarkTracker&&) noexcept = default;

void LandmarkTracker::add(const SensorMessage& message) { impl_->add(message); }
void LandmarkTracker::add(const LandmarkReading& reading) { impl_->add(reading); }
std::optional<LocalizationEstimate> LandmarkTracker::next_update() { return impl_->next_update(); }
LocalizationResult LandmarkTracker::finish() { return impl_->finish(); }
std::int64_t LandmarkTracker::scans_with_intensities() const {
  return impl_->scans_with_intensities();
}
std::int64_t LandmarkTracker::observations() const { return impl_->observations(); }

}  // namespace loopstone
