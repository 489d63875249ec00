#include "loopstone/localization/localizer.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "localization/belief_snapshots.hpp"
#include "localization/confidence.hpp"
#include "localization/map_proof.hpp"
#include "localization/map_tables.hpp"
#include "localization/near_search.hpp"
#include "localization/other_lasers.hpp"
#include "localization/place_search.hpp"
#include "localization/pose_evidence.hpp"
#include "localization/pose_track.hpp"
#include "localization/robot_motion.hpp"
#include "localization/scan_weigher.hpp"
#include "localization/state_judge.hpp"
#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/base/option_list.hpp"
#include "loopstone/base/thinned.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/pose_distance.hpp"
#include "loopstone/geometry/rigid_motion.hpp"
#include "loopstone/localization/localization_scan.hpp"
#include "loopstone/localization/pose_belief.hpp"
#include "loopstone/odometry/odometry_check.hpp"
#include "loopstone/odometry/scan_queue.hpp"
#include "loopstone/sensor/mounted_scan.hpp"

namespace loopstone {

namespace {

/// A refined pose so far from its particles has gone astray.
constexpr double kAstrayM = 0.4;
constexpr double kAstrayRad = 0.2;
/// Belief that is given to the places that a search finds, before they are weighed. A place that
/// has been followed was weighed many times; one scan must not overturn that unless the robot is
/// lost anyway.
constexpr double kNewPlacesShare = 0.003;
constexpr double kNewPlacesShareWhenLost = 0.5;
constexpr double kNewPlacesShareWhenJumped = 0.2;
/// Against those places, when others were found where the robot may have slipped to.
constexpr double kFarLogOdds = 6.0;
/// A place this near to the one followed is that one, after a slip.
constexpr double kSlippedM = 2.0;
constexpr double kSlippedRad = 1.2;
/// Belief in the one pose near by that explains a scan which contradicted the map before.
constexpr double kSlippedShare = 0.9;
/// The least that the mean of a place's particles is uncertain by.
constexpr double kSpotM = 0.02;
constexpr double kSpotRad = 0.01;
/// A scan contradicts the map that fits by so much less than those before it did.
constexpr double kWorse = 0.12;
constexpr double kMuchWorse = 0.17;
/// Where odometry may have missed so much, the robot is looked for before scans contradict.
constexpr double kUntoldM = 0.15;
/// Scans fit the map that fit so well from more right poses than wrong ones.
constexpr double kFits = 0.5;
/// Returns used for registration.
constexpr std::size_t kRefinePoints = 240;

PoseWithCovariance2 pose_given(const InitialPose& initial) {
  PoseWithCovariance2 given{.pose = initial.map_T_robot};
  given.covariance.diagonal() << initial.sigma_m * initial.sigma_m,
      initial.sigma_m * initial.sigma_m, initial.sigma_rad * initial.sigma_rad;
  return given;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

class Localizer::Impl {
 public:
  Impl(const LocalizationMap& map, const RobotModel& robot, const LocalizationOptions& options,
       const std::optional<InitialPose>& initial, std::uint64_t seed, Threads threads)
      : map_(map),
        robot_(robot),
        options_(options),
        initial_(initial),
        queue_(robot.wheels),
        weigher_(map, options.sensor, threads),
        motion_(options),
        belief_({.particles_max = options.particles_max,
                 .particles_min = options.particles_min,
                 .resampling = options.resampling,
                 .places_max = kPlacesMost},
                seed, threads),
        state_(options.tracking_probability, options.lost_probability),
        snapshots_(options.snapshot_distance_m) {}

  void add(const SensorMessage& message) {
    const auto mounted = as_mounted(message, robot_);
    queue_.add(mounted ? *mounted : message);
    process_ready();
  }

  void restart_at(const InitialPose& initial) {
    initial_ = initial;
    foretold_ = pose_given(initial);
    forget();
    riding_.reset();
    motion_.carried();
  }

  std::optional<LocalizationEstimate> next_update() {
    if (handed_out_ == result_.estimates.size()) return {};
    return result_.estimates[handed_out_++];
  }

  [[nodiscard]] std::vector<Pose2> particles() const {
    std::vector<Pose2> poses;
    poses.reserve(belief_.particles().size());
    for (const Pose2& particle : belief_.particles())
      poses.push_back(particle * motion_.since_weighing().pose);
    return poses;
  }

  LocalizationResult finish() {
    queue_.finish();
    process_ready();
    if (motion_.first_stamp()) {
      result_.start = *motion_.first_stamp();
      result_.duration_s = (*motion_.last_stamp() - *motion_.first_stamp()).seconds();
    }
    result_.path_length_m = motion_.travelled_m();
    result_.had_odometry = motion_.had_odometry();
    result_.snapshots = snapshots_.take();
    if (result_.estimates.empty() && result_.scans > 0) {
      result_.warnings.emplace_back(
          "no place on the map explains the scans: is it the map of this building, at the height "
          "of this laser?");
    }
    if (!result_.had_odometry && result_.scans > 0) {
      result_.warnings.emplace_back(
          "the log has no odometry: the robot is assumed to keep its velocity from scan to scan");
    }
    for (const OdometryEpisode& episode : check_.episodes()) {
      result_.warnings.push_back(fmt::format(
          "odometry was not used from {:.1f} s{}: {}", (episode.noticed - result_.start).seconds(),
          episode.over ? fmt::format(" to {:.1f} s", (episode.to - result_.start).seconds())
                       : std::string(" on"),
          what_is_wrong(episode)));
    }
    return std::move(result_);
  }

 private:
  /// All that was believed; not how the robot has moved.
  void forget() {
    belief_.forget();
    track_.reset();
    untold_at_m_.reset();
    best_id_ = -1;
    fit_.reset();
    lately_.reset();
    along_.reset();
    state_.begin_anew();
    proof_.begin_anew();
    doubted_scans_ = 0;
    jumped_ = false;
    rest_share_ = 0.0;
    last_fix_.reset();
  }

  void process_ready() {
    while (const auto scan = queue_.next()) {
      const auto start = std::chrono::steady_clock::now();
      const double searched_before = result_.search_s;
      process(*scan);
      result_.filter_s += seconds_since(start) - (result_.search_s - searched_before);
    }
  }

  void process(const LaserScan& scan) {
    if (motion_.last_stamp() && scan.stamp <= *motion_.last_stamp()) {
      if (scan.stamp == *motion_.last_stamp() && scan.lidar != last_lidar_) take_beside(scan);
      return;
    }
    ++result_.scans;
    last_lidar_ = scan.lidar;
    const PoseWithCovariance2 motion =
        motion_.step_to(scan.stamp, queue_.odometer(),
                        {check_.translation().trusted(), check_.rotation().trusted()});
    odom_T_robot_ = odom_T_robot_ * motion.pose;
    if (track_) {
      advance(*track_, motion);
      foretold_ = track_->map_T_robot();
    }
    if (riding_) advance(*riding_, motion);
    others_.move(motion.pose);
    const LocalizationScan view = look_around(scan);
    const bool seen = shows_place(view);
    const bool told = !seen || find_after_gap(view);
    if (!seen) {
      ++result_.scans_dropped;
    } else if (belief_.empty()) {
      start(view);
    } else if (is_worth_another_start(view)) {
      start_with_more(view);
    } else if (told && motion_.moved(options_.update_distance_m, options_.update_angle_rad)) {
      weigh(view);
    }
    if (belief_.empty()) return;
    follow_best_place(view);
    const bool refined = seen && told && refine_or_find(view);
    motion_.found_at(track_->map_T_robot().pose);
    LocalizationEstimate estimate = judge(view, refined);
    if (seen && options_.recover && (rejoin(view, estimate) || recover(view, estimate))) {
      follow_best_place(view);
      estimate = judge(view, refine(view));
    }
    check_odometry(estimate);
    report(view, std::move(estimate));
  }

  [[nodiscard]] SeenByLaser view_of(const LaserScan& scan) const {
    return view_of_laser(scan, mount_of(scan, robot_), motion_.velocity(), options_.beams);
  }

  /// What the scan shows, and what the robot's other lasers saw a moment ago. A laser that is
  /// covered says nothing while another one sees.
  LocalizationScan look_around(const LaserScan& scan) {
    SeenByLaser own = view_of(scan);
    std::vector<SeenByLaser> lasers = others_.beside(scan.lidar, scan.stamp);
    const bool is_seeing = sees(own);
    if (is_seeing) others_.remember(scan.lidar, scan.stamp, own);
    if (is_seeing || lasers.empty()) lasers.insert(lasers.begin(), std::move(own));
    return view_together(std::move(lasers), options_.beams);
  }

  /// Of lasers that scan at the same moment one has an estimate; the others help with it, and with
  /// the next one.
  void take_beside(const LaserScan& scan) {
    ++result_.scans;
    const SeenByLaser view = view_of(scan);
    if (!sees(view)) return;
    others_.remember(scan.lidar, scan.stamp, view);
    if (track_ && !belief_.empty()) refine_with(view);
  }

  /// Odometry is held against the way between scans that fit: where they contradict each other for
  /// long, it is wrong.
  void check_odometry(const LocalizationEstimate& estimate) {
    constexpr double kKnownM = 0.06;
    constexpr double kKnownRad = 0.03;
    constexpr double kFastestMS = 3.0;
    constexpr double kSlackM = 0.5;
    if (!newest_fit_) return;
    const Eigen::Matrix3d& covariance = estimate.covariance;
    const bool is_known = covariance.topLeftCorner<2, 2>().trace() < kKnownM * kKnownM &&
                          covariance(2, 2) < kKnownRad * kKnownRad;
    // Off the map what is seen may fit where it does not belong.
    constexpr double kMapped = 0.8;
    constexpr double kBelief = 0.9;
    if (!is_known || estimate.evidence.mass < kBelief || newest_fit_->known < kMapped ||
        quality_of(*newest_fit_) < as_usual()) {
      return;
    }
    const Fix fix{estimate.stamp, estimate.map_T_robot};
    if (last_fix_) {
      const Pose2 laser = last_fix_->map_T_robot.inverse() * fix.map_T_robot;
      const double farthest_m = kSlackM + kFastestMS * (fix.stamp - last_fix_->stamp).seconds();
      const auto told = queue_.odometer().motion_between(last_fix_->stamp, fix.stamp);
      const bool is_motion = laser.translation().norm() < farthest_m;
      if (told && is_motion)
        check_.add(
            {.from = last_fix_->stamp, .to = fix.stamp, .odometry = told->pose, .laser = laser});
    }
    last_fix_ = fix;
  }

  void advance(PoseTrack& track, const PoseWithCovariance2& motion) const {
    if (motion_.is_told()) {
      track.advance(OdometryStep{motion, motion_.velocity_change()});
    } else {
      track.advance(motion);
    }
  }

  /// The first belief: around the pose given, or wherever the map explains the scan.
  void start(const LocalizationScan& view) {
    if (initial_) {
      start_around(view, *initial_);
    } else if (pace_.due(motion_.travelled_m())) {
      belief_.add(search(view, "start"), 1.0);
    }
    if (belief_.empty()) return;
    lasers_at_start_ = view.lasers.size();
    started_at_m_ = motion_.travelled_m();
    particles_weighed(view);
  }

  /// A robot that was looked for by one laser, and whose others tell a moment later what they see:
  /// places that looked alike to the one may not to all of them.
  [[nodiscard]] bool is_worth_another_start(const LocalizationScan& view) const {
    constexpr double kStillThereM = 0.3;
    return !initial_ && !state_.is_tracking() && view.lasers.size() > lasers_at_start_ &&
           motion_.travelled_m() - started_at_m_ < kStillThereM;
  }

  void start_with_more(const LocalizationScan& view) {
    lasers_at_start_ = view.lasers.size();
    const std::vector<PoseBelief::Proposal> proposals = search(view, "start");
    if (proposals.empty()) return;
    const double rest_share = rest_share_;
    forget();
    rest_share_ = rest_share;
    belief_.add(proposals, 1.0);
    particles_weighed(view);
  }

  /// A pose given by hand may be wrong. Other places that explain the scan are kept in mind, as
  /// unlikely ones: where the given place is only similar to the true one, the true one wins soon.
  void start_around(const LocalizationScan& view, const InitialPose& initial) {
    constexpr double kGivenIsWrong = 0.03;
    const PoseBelief::Proposal given{.map_T_robot = pose_given(initial)};
    belief_.add(std::span(&given, 1), 1.0);
    if (!options_.recover) return;
    std::vector<PoseBelief::Proposal> proposals = search(view, "start");
    rest_share_ = 0.0;
    bool any_as_given = false;
    for (PoseBelief::Proposal& proposal : proposals) {
      const bool as_given = agrees(proposal.map_T_robot.pose, initial);
      any_as_given = any_as_given || as_given;
      proposal.log_mass = as_given ? 0.0 : std::log(kGivenIsWrong);
    }
    belief_.add(proposals, any_as_given ? 0.5 : kGivenIsWrong);
  }

  [[nodiscard]] static bool agrees(const Pose2& pose, const InitialPose& initial) {
    constexpr double kSigmas = 3.0;
    return is_within(pose, initial.map_T_robot, kSigmas * initial.sigma_m,
                     kSigmas * initial.sigma_rad);
  }

  /// Moves the particles to now and weighs them.
  void weigh(const LocalizationScan& view) {
    move_particles();
    particles_weighed(view);
  }

  void move_particles() {
    std::optional<PoseWithCovariance2> track;
    if (track_) track = track_->map_T_robot();
    belief_.predict(motion_.sampler(track));
    motion_.particles_moved();
  }

  void particles_weighed(const LocalizationScan& view) {
    belief_.update([&](std::span<const Pose2> poses,
                       std::span<double> out) { weigher_.log_likelihoods(view, poses, out); },
                   ScanWeigher::independent_readings(view),
                   [&](const PlaceBelief& place) { return weigher_.evidence_of(view, place); });
    // A robot that is TRACKING and slips is looked for near by: its particles need not spread.
    belief_.settle(!state_.is_tracking());
    motion_.particles_weighed();
  }

  /// Keeps the track on the most probable place.
  void follow_best_place(const LocalizationScan& view) {
    if (const auto mean = choose_best_place()) restart_track(better_start(view, no_surer(*mean)));
  }

  /// Where the most probable place is, when the track is not on it.
  std::optional<PoseWithCovariance2> choose_best_place() {
    const PlaceBelief& best = belief_.places().front();
    PoseWithCovariance2 mean = compound(best.moments, motion_.since_weighing());
    // Few particles may stand on one spot; they don't know it that well.
    mean.covariance.diagonal() +=
        Eigen::Vector3d(kSpotM * kSpotM, kSpotM * kSpotM, kSpotRad * kSpotRad);
    const bool changed = !track_ || best.id != best_id_;
    if (changed) {
      best_id_ = best.id;
      // After a slip it is the same place still.
      if (!track_ || !is_within(mean.pose, track_->map_T_robot().pose, kSlippedM, kSlippedRad)) {
        best_since_m_ = motion_.travelled_m();
        fit_.reset();
        lately_.reset();
        along_.reset();
        state_.begin_anew();
      }
    }
    const auto astray = [&] {
      const Pose2& pose = track_->map_T_robot().pose;
      const double spread = std::sqrt(mean.covariance.topLeftCorner<2, 2>().trace());
      return hypotenuse(pose.x - mean.pose.x, pose.y - mean.pose.y) > kAstrayM + 2.0 * spread ||
             std::abs(wrap_angle(pose.yaw - mean.pose.yaw)) >
                 kAstrayRad + 2.0 * std::sqrt(mean.covariance(2, 2));
    };
    if (changed || astray()) return mean;
    return {};
  }

  /// Along a corridor few particles stand for a long way. Where the track says that the robot may
  /// be anywhere about here, another of them says nothing new.
  [[nodiscard]] PoseWithCovariance2 no_surer(PoseWithCovariance2 mean) const {
    constexpr double kWithin2 = 16.0;  // squared Mahalanobis distance
    if (!track_) return mean;
    const PoseWithCovariance2& track = track_->map_T_robot();
    const Eigen::Vector3d apart = RigidMotion<2>::difference(mean.pose, track.pose);
    const Eigen::Matrix3d covariance = mean.covariance + track.covariance;
    if (apart.dot(covariance.inverse() * apart) < kWithin2) mean.covariance = covariance;
    return mean;
  }

  /// Particles that are spread out tell the place, but no pose to register a scan from.
  [[nodiscard]] PoseWithCovariance2 better_start(const LocalizationScan& view,
                                                 const PoseWithCovariance2& mean) const {
    constexpr double kSureM = 0.15;
    constexpr double kSureRad = 0.1;
    constexpr double kBetter = 0.05;
    const Eigen::Matrix3d& covariance = mean.covariance;
    const double sigma_m = std::sqrt(std::max(covariance(0, 0), covariance(1, 1)));
    if (sigma_m < kSureM && std::sqrt(covariance(2, 2)) < kSureRad) return mean;
    if (!shows_place(view)) return mean;
    const double here = quality_of(fit_beams(view, map_, mean.pose));
    return find_nearby(view, map_, mean, here + kBetter).value_or(mean);
  }

  /// Elsewhere, by a robot with the same wheels.
  void restart_track(const PoseWithCovariance2& map_T_robot) {
    track_.emplace(map_T_robot, track_ ? track_->errors() : OdometryErrors{});
  }

  bool refine_or_find(const LocalizationScan& view) {
    const bool refined = refine(view);
    return look_nearby(view) || refined;
  }

  /// Where scans contradict the map as they did not before, the robot has slipped by a little more
  /// often than anything else has happened. True when it was found again.
  bool look_nearby(const LocalizationScan& view) {
    if (!options_.recover || !lately_.any()) return false;
    const double here = quality_of(fit_beams(view, map_, track_->map_T_robot().pose));
    if (here >= quality_of(lately_.mean()) - kWorse) {
      near_pace_.found();
      return false;
    }
    if (!near_pace_.due()) return false;
    const auto found = find_nearby(view, map_, foretold_, std::max(here + kWorse, as_usual()));
    if (!found) {
      near_pace_.in_vain();
      return false;
    }
    near_pace_.found();
    // A place that is only similar may lie where the robot could have slipped to.
    constexpr double kJumpM = 0.5;
    jumped_ = (found->pose.translation() - foretold_.pose.translation()).norm() > kJumpM;
    adopt(*found);
    return true;
  }

  /// Quality below which a scan does not fit as those before it did. People and what else the map
  /// lacks make wrong poses fit a little better, never as before.
  [[nodiscard]] double as_usual() const {
    constexpr double kLeast = 0.6;
    return std::max(kLeast, lately_.any() ? usual_quality() - kWorse : kLeast);
  }

  [[nodiscard]] double usual_quality() const {
    return std::max(quality_of(lately_.mean()), quality_of(along_.mean()));
  }

  /// Where counts were lost, the robot is looked for before a scan is registered: registration
  /// would take the nearest pose that fits, and be sure of it. False until it is found, for some
  /// metres.
  bool find_after_gap(const LocalizationScan& view) {
    constexpr double kLongestM = 3.0;
    constexpr double kSameM = 0.3;
    constexpr double kSameRad = 0.2;
    if (!options_.recover || !track_) return true;
    if (motion_.untold_m() > kUntoldM) untold_at_m_ = motion_.travelled_m();
    if (!untold_at_m_) return true;
    if (motion_.travelled_m() - *untold_at_m_ > kLongestM) {
      untold_at_m_.reset();
      return true;
    }
    if (!near_pace_.due()) return false;
    const auto found =
        find_nearby(view, map_, riding_ ? riding_->map_T_robot() : foretold_, as_usual());
    if (!found) {
      near_pace_.in_vain();
      return false;
    }
    near_pace_.found();
    untold_at_m_.reset();
    if (!is_within(found->pose, track_->map_T_robot().pose, kSameM, kSameRad)) adopt(*found);
    return true;
  }

  /// The robot is found where it may well be.
  void adopt(const PoseWithCovariance2& found) {
    constexpr double kSpreadM = 0.05;
    constexpr double kSpreadRad = 0.03;
    PoseBelief::Proposal proposal{.map_T_robot = found};
    proposal.map_T_robot.covariance.diagonal() +=
        Eigen::Vector3d(kSpreadM * kSpreadM, kSpreadM * kSpreadM, kSpreadRad * kSpreadRad);
    move_particles();
    belief_.add(std::span(&proposal, 1), kSlippedShare);
    belief_.settle();
    (void)choose_best_place();
    restart_track(found);
  }

  /// A robot that drove off the map, or through a crowd, comes back where odometry says.
  bool rejoin(const LocalizationScan& view, const LocalizationEstimate& estimate) {
    constexpr double kWell = 0.75;
    constexpr double kBetter = 0.1;
    if (estimate.state == LocalizationState::kTracking) {
      riding_ = *track_;
      ride_pace_m_ = 0.0;
      return false;
    }
    constexpr double kPaceM = 0.3;
    if (!is_riding() || motion_.travelled_m() < ride_pace_m_) return false;
    ride_pace_m_ = motion_.travelled_m() + kPaceM;
    const PoseWithCovariance2& ridden = riding_->map_T_robot();
    const double here = quality_of(fit_beams(view, map_, estimate.map_T_robot));
    if (here > kWell - kBetter) return false;
    const auto found = find_nearby(view, map_, ridden, kWell);
    if (!found || quality_of(fit_beams(view, map_, found->pose)) < here + kBetter) return false;
    adopt(*found);
    return true;
  }

  /// Each laser in its turn: what the others saw was taken in when they saw it.
  bool refine(const LocalizationScan& view) { return refine_with(view.lasers.front()); }

  bool refine_with(const SeenByLaser& view) {
    return track_->refine(thinned(view.points_robot, kRefinePoints),
                          view.robot_T_lidar.translation(), map_.tables().search.field(), offset_);
  }

  /// The way since the last scan that counts: turning shows something new as well, standing little.
  double evidence_way_m() {
    constexpr double kMetresPerRad = 0.3;
    constexpr double kStandingM = 0.002;
    const Pose2 step = odom_at_fit_.inverse() * odom_T_robot_;
    odom_at_fit_ = odom_T_robot_;
    return step.translation().norm() + kMetresPerRad * std::abs(step.yaw) + kStandingM;
  }

  /// People and what else the map lacks draw the pose to where they stand.
  [[nodiscard]] Eigen::Matrix3d crowded(const Eigen::Matrix3d& covariance) const {
    constexpr double kUnexpected = 15.0;
    return (1.0 + kUnexpected * lately_.mean().unexpected) * covariance;
  }

  LocalizationEstimate judge(const LocalizationScan& view, bool refined) {
    const PlaceBelief& best = belief_.places().front();
    LocalizationEstimate estimate;
    estimate.stamp = *motion_.last_stamp();
    estimate.map_T_robot = track_->map_T_robot().pose;
    estimate.odom_T_robot = odom_T_robot_;
    estimate.covariance = crowded(track_->covariance());
    estimate.refined = refined;
    estimate.places = places_now();
    estimate.hypotheses = static_cast<int>(estimate.places.size());
    estimate.particles = static_cast<int>(belief_.particle_count());
    estimate.travelled_m = motion_.travelled_m();
    const double way_m = evidence_way_m();
    bool worse = false;
    newest_fit_.reset();
    if (shows_place(view)) {
      const BeamFit& newest = newest_fit_.emplace(fit_beams(view, map_, estimate.map_T_robot));
      worse = lately_.any() && quality_of(newest) < usual_quality() - kMuchWorse;
      fit_.add(newest);
      lately_.add(newest, way_m);
      along_.add(newest, way_m);
    } else {
      fit_.add_blind_scan();
      lately_.add_blind_scan(way_m);
      along_.add_blind_scan(way_m);
    }
    const BeamFit fit = fit_.mean();
    const Eigen::Matrix3d& spread = best.moments.covariance;
    estimate.evidence = {
        .explained = fit.explained,
        .violations = fit.violations,
        .unexpected = fit.unexpected,
        .mass = mass_near(best, estimate.map_T_robot * motion_.since_weighing().pose.inverse()) *
                (1.0 - rest_share_),
        .precision = precision_of(estimate.covariance),
        .spread_m = std::sqrt(spread(0, 0) + spread(1, 1)),
        .spread_rad = std::sqrt(spread(2, 2)),
        .innovation = track_->innovation(),
        .followed_m = motion_.travelled_m() - best_since_m_,
        .known = fit.known,
        .silent = fit.silent,
        .lately = lately_.mean(),
        .along = along_.mean()};
    const bool fits = fit_probability(estimate.evidence) >= kFits;
    estimate.evidence.unproven =
        proof_.doubt_at(motion_.travelled_m(), fits, estimate.evidence.followed_m);
    estimate.probability = pose_probability(estimate.evidence);
    // A pose that is imprecise along a corridor is not lost: it is in the right place.
    const double place_probability =
        estimate.probability / std::max(estimate.evidence.precision, 1e-9);
    estimate.state = state_.judge(estimate.probability, place_probability, way_m, worse);
    // Nothing contradicts odometry while the laser shows nothing.
    const bool is_unseen = !newest_fit_ && is_riding();
    if (is_unseen && estimate.state == LocalizationState::kLost)
      estimate.state = LocalizationState::kDoubtful;
    return estimate;
  }

  /// Searches the map when the pose is doubted for some scans, and lets what it finds compete. True
  /// when it found something.
  bool recover(const LocalizationScan& view, const LocalizationEstimate& estimate) {
    constexpr int kDoubtedScans = 3;
    if (estimate.state == LocalizationState::kTracking && !jumped_) {
      doubted_scans_ = 0;
      pace_.calm();
      return false;
    }
    // Where another place explains the scans as well, only motion can tell: no search can. But
    // scans that don't fit, or places that were too many to follow, are worth another look.
    const PoseEvidence& evidence = estimate.evidence;
    const double fits = estimate.probability / std::max(evidence.mass * evidence.precision, 1e-9);
    const bool worthwhile = fits < kFits || rest_share_ > 0.0 || state_.fits_worse_for_long();
    doubted_scans_ = worthwhile ? doubted_scans_ + 1 : 0;
    const bool due = doubted_scans_ >= kDoubtedScans && pace_.due(motion_.travelled_m());
    if (!due && !jumped_) return false;
    doubted_scans_ = 0;
    const bool lost = estimate.state == LocalizationState::kLost;
    std::vector<PoseBelief::Proposal> proposals = search(view, jumped_ ? "jumped"
                                                               : lost  ? "lost"
                                                                       : "doubtful");
    if (is_riding()) {
      // Something stands around the robot, or it slipped: other places must explain more than that.
      constexpr double kMore = 0.05;
      const double here = quality_of(fit_beams(view, map_, estimate.map_T_robot));
      std::erase_if(proposals, [&](const auto& proposal) {
        return quality_of(fit_beams(view, map_, proposal.map_T_robot.pose)) < here + kMore;
      });
    }
    const double prior = jumped_ ? kNewPlacesShareWhenJumped
                         : lost  ? kNewPlacesShareWhenLost
                                 : kNewPlacesShare;
    const double far_log_odds = std::exchange(jumped_, false) ? 0.0 : kFarLogOdds;
    if (proposals.empty()) return false;
    compete(view, estimate, std::move(proposals), prior, far_log_odds);
    return true;
  }

  /// New places against old ones, by how well each explains this scan.
  void compete(const LocalizationScan& view, const LocalizationEstimate& estimate,
               std::vector<PoseBelief::Proposal> proposals, double prior, double far_log_odds) {
    double best_log = -std::numeric_limits<double>::infinity();
    // A robot slips by a metre more often than it is carried to a place that looks the same.
    const auto nearby = [&](const PoseBelief::Proposal& proposal) {
      return is_near(proposal.map_T_robot.pose, estimate);
    };
    const bool any_near = std::any_of(proposals.begin(), proposals.end(), nearby);
    for (auto& proposal : proposals) {
      if ((any_near || (is_riding() && !looks_carried())) && !nearby(proposal))
        proposal.log_mass -= far_log_odds;
      proposal.log_mass += weigher_.best_evidence(view, std::span(&proposal.map_T_robot.pose, 1));
      best_log = std::max(best_log, proposal.log_mass);
    }
    double old_sum = 0.0;
    for (const PlaceBelief& place : belief_.places()) {
      const Pose2 now = place.id == best_id_ ? estimate.map_T_robot
                                             : place.moments.pose * motion_.since_weighing().pose;
      old_sum +=
          std::exp(place.log_mass + weigher_.best_evidence(view, std::span(&now, 1)) - best_log);
    }
    double new_sum = 0.0;
    for (const auto& proposal : proposals)
      new_sum += std::exp(proposal.log_mass - best_log) / static_cast<double>(proposals.size());
    const double ratio = prior / (1.0 - prior) * new_sum / std::max(old_sum, 1e-12);
    const bool lost = estimate.state == LocalizationState::kLost;
    // The particles stand where they were weighed last; move them to now before others join them.
    move_particles();
    belief_.add(proposals, std::clamp(ratio / (1.0 + ratio), 1e-3, lost ? 0.98 : 0.5));
    belief_.settle();
  }

  /// Odometry still tells where the robot is, since the pose was sure: then it is not far from
  /// there, unless somebody carried it.
  [[nodiscard]] bool is_riding() const {
    constexpr double kNearM = 1.5;
    if (!riding_) return false;
    const Eigen::Matrix3d& covariance = riding_->map_T_robot().covariance;
    return std::max(covariance(0, 0), covariance(1, 1)) < kNearM * kNearM;
  }

  /// Beams go through walls that the map is sure of: no crowd does that, nor new furniture.
  [[nodiscard]] bool looks_carried() const {
    constexpr double kThrough = 0.1;
    constexpr double kKnown = 0.7;
    return fit_.mean().violations > kThrough && fit_.mean().known > kKnown;
  }

  std::vector<PoseBelief::Proposal> search(const LocalizationScan& view, const char* reason) {
    const auto start = std::chrono::steady_clock::now();
    PlacesFound found = find_places(view, map_);
    LocalizationSearch record{.stamp = *motion_.last_stamp(), .reason = reason, .whole_map = true};
    record.poses_found = static_cast<int>(found.proposals.size());
    record.poses_added = static_cast<int>(
        std::count_if(found.proposals.begin(), found.proposals.end(),
                      [&](const auto& proposal) { return !is_known(proposal.map_T_robot.pose); }));
    record.best_score = found.best_score;
    rest_share_ = found.complete ? 0.0 : kRestShare;
    result_.searches.push_back(std::move(record));
    pace_.searched(motion_.travelled_m());
    result_.search_s += seconds_since(start);
    return std::move(found.proposals);
  }

  /// Is a pose where the robot may be by what was believed, but for a slip of the wheels?
  [[nodiscard]] static bool is_near(const Pose2& pose, const LocalizationEstimate& estimate) {
    constexpr double kSlipM = 3.0;
    constexpr double kSlipRad = 1.0;
    constexpr double kSigmas = 4.0;
    const double sigma_m = std::sqrt(estimate.covariance.topLeftCorner<2, 2>().trace());
    return is_within(pose, estimate.map_T_robot, kSlipM + kSigmas * sigma_m, kSlipRad);
  }

  [[nodiscard]] bool is_known(const Pose2& pose) const {
    constexpr double kSameM = 0.5;
    constexpr double kSameRad = 0.3;
    return std::any_of(belief_.places().begin(), belief_.places().end(),
                       [&](const PlaceBelief& place) {
                         return is_within(place.moments.pose * motion_.since_weighing().pose, pose,
                                          kSameM, kSameRad);
                       });
  }

  void report(const LocalizationScan& view, LocalizationEstimate estimate) {
    if (estimate.state == LocalizationState::kTracking)
      weigher_.learn_from(view, estimate.map_T_robot);
    if (result_.changes.empty() || result_.changes.back().state != estimate.state)
      result_.changes.push_back({estimate.stamp, estimate.state});
    if (snapshots_.due(motion_.travelled_m()))
      snapshots_.add(snapshot_of(view, estimate), motion_.travelled_m());
    result_.estimates.push_back(std::move(estimate));
  }

  /// Where the robot may be, moved on from where the particles were weighed last.
  [[nodiscard]] std::vector<LocalizationHypothesis> places_now() const {
    std::vector<LocalizationHypothesis> places;
    for (const PlaceBelief& place : belief_.places()) {
      places.push_back(
          {place.moments.pose * motion_.since_weighing().pose, std::exp(place.log_mass)});
    }
    return places;
  }

  [[nodiscard]] BeliefSnapshot snapshot_of(const LocalizationScan& view,
                                           const LocalizationEstimate& estimate) const {
    BeliefSnapshot snapshot{.stamp = estimate.stamp, .points = view.weighed, .estimate = estimate};
    snapshot.hypotheses = places_now();
    snapshot.particles = particles();
    return snapshot;
  }

  const LocalizationMap& map_;
  RobotModel robot_;
  LocalizationOptions options_;
  std::optional<InitialPose> initial_;
  ScanQueue queue_;
  ScanWeigher weigher_;
  /// Where the robot was, by a scan that fits.
  struct Fix {
    Stamp stamp{};
    Pose2 map_T_robot{};
  };

  RobotMotion motion_;
  OdometryCheck check_{};
  std::optional<Fix> last_fix_{};
  PoseBelief belief_;

  OtherLasers others_{};
  int last_lidar_ = 0;  ///< whose scan has the newest estimate
  std::size_t lasers_at_start_ = 0;
  double started_at_m_ = 0.0;
  Pose2 odom_T_robot_{};
  std::optional<PoseTrack> track_{};  // of the most probable place
  RangeOffset offset_{};
  int best_id_ = -1;
  double best_since_m_ = 0.0;
  std::optional<BeamFit> newest_fit_{};  ///< at the newest estimate; none where nothing is seen
  RecentFit fit_{};
  FitAlongWay lately_{1.5};
  FitAlongWay along_{8.0};
  StateJudge state_;
  MapProof proof_{};
  Pose2 odom_at_fit_{};
  NearSearchPace near_pace_{};
  PoseWithCovariance2 foretold_{};       ///< at this scan, before it was looked at
  std::optional<double> untold_at_m_{};  ///< where counts were lost, until the robot is found
  int doubted_scans_ = 0;
  std::optional<PoseTrack>
      riding_{};  ///< from where the state was TRACKING last, by odometry alone
  double ride_pace_m_ = 0.0;
  bool jumped_ = false;  ///< found near by, farther than wheels mostly slip: is it so elsewhere?
  double rest_share_ = 0.0;
  SearchPace pace_{};

  LocalizationResult result_{};
  std::size_t handed_out_ = 0;
  BeliefSnapshots snapshots_;
};

Localizer::Localizer(const LocalizationMap& map, const RobotModel& robot,
                     const LocalizationOptions& options, const std::optional<InitialPose>& initial,
                     std::uint64_t seed, Threads threads)
    : impl_((require_valid(options),
             std::make_unique<Impl>(map, robot, options, initial, seed, threads))) {}
Localizer::~Localizer() = default;
Localizer::Localizer(Localizer&&) noexcept = default;
Localizer& Localizer::operator=(Localizer&&) noexcept = default;

void Localizer::add(const SensorMessage& message) { impl_->add(message); }
void Localizer::restart_at(const InitialPose& initial) { impl_->restart_at(initial); }
std::optional<LocalizationEstimate> Localizer::next_update() { return impl_->next_update(); }
std::vector<Pose2> Localizer::particles() const { return impl_->particles(); }
LocalizationResult Localizer::finish() { return impl_->finish(); }

}  // namespace loopstone
