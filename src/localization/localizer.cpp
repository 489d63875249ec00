#include "loopstone/localization/localizer.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <limits>
#include <utility>
#include <vector>

#include "localization/confidence.hpp"
#include "localization/learned_beam_sensor.hpp"
#include "localization/map_tables.hpp"
#include "localization/pose_track.hpp"
#include "loopstone/base/thinned.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/localization/localization_scan.hpp"
#include "loopstone/localization/motion_models.hpp"
#include "loopstone/localization/pose_belief.hpp"
#include "loopstone/registration/field_match.hpp"
#include "loopstone/slam/scan_queue.hpp"

namespace loopstone {

namespace {

/// Fewer returns say nothing.
constexpr std::size_t kLeastReturns = 10;
/// Beams of one scan are not independent: furniture and the map's errors touch many at once. So many count as one.
constexpr double kBeamsAsOne = 6.0;
/// Between places the same errors of the map come back with every scan, so far fewer readings are independent: in corridors that
/// look alike, on a map drawn years before, 10 made the wrong one certain within some metres.
constexpr double kBeamsAsOneOfPlace = 40.0;
/// Share of the newest scan in the evidence: bad news counts at once.
constexpr double kNewestGood = 0.3;
constexpr double kNewestBad = 0.7;
/// Share of what was explained that is forgotten with each scan without returns.
constexpr double kForgotten = 0.05;
/// The search calls a place sure when nothing else explains the scan nearly as well; none of a thousand was wrong.
constexpr double kSureLogOdds = 7.0;
/// Places that are followed at once.
constexpr int kPlacesMost = 300;
/// Belief in the rest of the map while more places look alike than can be followed.
constexpr double kRestShare = 0.3;
/// A refined pose so far from its particles has gone astray.
constexpr double kAstrayM = 0.4;
constexpr double kAstrayRad = 0.2;
/// Belief that is given to the places that a search finds, before they are weighed. A place that has been followed was weighed
/// many times; one scan must not overturn that unless the robot is lost anyway.
constexpr double kNewPlacesShare = 0.003;
constexpr double kNewPlacesShareWhenLost = 0.5;
/// Against those places, when others were found where the robot may have slipped to.
constexpr double kFarLogOdds = 6.0;
/// Returns used for registration.
constexpr std::size_t kRefinePoints = 240;
/// Without odometry the robot keeps its velocity, give or take.
constexpr double kUnknownSpeed = 0.4;    // [m/s]
constexpr double kUnknownYawRate = 0.8;  // [rad/s]
/// Dead reckoning's own covariance leaves out what is systematic.
constexpr double kOdometryFactor = 2.0;
/// Particles spread at least so much with each step, or few would stand for many.
constexpr double kJitterM = 0.01;
constexpr double kJitterRad = 0.005;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// A mean of the last values that follows bad news at once and good news slowly.
double followed(double mean, double value, bool worse) {
  return mean + (worse ? kNewestBad : kNewestGood) * (value - mean);
}

/// Probability that a Gaussian error stays within 0.2 m, along its longest axis, and 5 deg.
double precision_of(const Eigen::Matrix3d& covariance) {
  constexpr double kWithinM = 0.2;
  constexpr double kWithinRad = 5.0 * kPi / 180.0;
  const double half_trace = 0.5 * (covariance(0, 0) + covariance(1, 1));
  const double half_gap = 0.5 * (covariance(0, 0) - covariance(1, 1));
  const double longest = half_trace + std::hypot(half_gap, covariance(0, 1));
  const auto within = [](double bound, double variance) {
    return std::erf(bound / std::sqrt(2.0 * std::max(variance, 1e-12)));
  };
  return within(kWithinM, longest) * within(kWithinRad, covariance(2, 2));
}

/// How widely particles are drawn around a pose that a search found: not too narrowly, as the lattice is coarse, nor along a
/// corridor farther than to the next pose found there.
Eigen::Matrix3d spread_of(const Eigen::Matrix3d& covariance) {
  constexpr double kLeastM = 0.05;
  constexpr double kMostM = 0.4;
  constexpr double kLeastRad = 0.03;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance.topLeftCorner<2, 2>());
  const Eigen::Vector2d variances =
      axes.eigenvalues().cwiseMax(kLeastM * kLeastM).cwiseMin(kMostM * kMostM);
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  spread.topLeftCorner<2, 2>() =
      axes.eigenvectors() * variances.asDiagonal() * axes.eigenvectors().transpose();
  spread(2, 2) = std::clamp(covariance(2, 2), kLeastRad * kLeastRad, kMostM * kMostM);
  return spread;
}

/// When the map is searched again: at once, then after ever more travel.
class SearchPace {
 public:
  [[nodiscard]] bool due(double travelled_m) const { return travelled_m >= next_m_; }
  void searched(double travelled_m) {
    next_m_ = travelled_m + interval_m_;
    interval_m_ = std::min(1.5 * interval_m_, 5.0);
  }
  void calm() { interval_m_ = kFirst; }

 private:
  static constexpr double kFirst = 0.5;
  double next_m_ = 0.0;
  double interval_m_ = kFirst;
};

}  // namespace

class Localizer::Impl {
 public:
  Impl(const LocalizationMap& map, const RobotModel& robot, const LocalizationOptions& options,
       const std::optional<InitialPose>& initial, std::uint64_t seed, Threads threads)
      : map_(map),
        robot_(robot),
        options_(options),
        initial_(initial),
        threads_(threads),
        queue_(robot.wheels),
        beam_sensor_(map.tables().caster),
        belief_({.particles_max = options.particles_max,
                 .particles_min = options.particles_min,
                 .resampling = resampling_scheme_from(options.resampling),
                 .places_max = kPlacesMost},
                seed, threads) {}

  void add(const SensorMessage& message) {
    queue_.add(message);
    process_ready();
  }

  std::optional<LocalizationEstimate> next() {
    if (handed_out_ == result_.estimates.size()) return {};
    return result_.estimates[handed_out_++];
  }

  LocalizationResult finish() {
    queue_.finish();
    process_ready();
    if (first_stamp_) {
      result_.start = *first_stamp_;
      result_.duration_s = (*last_stamp_ - *first_stamp_).seconds();
    }
    result_.path_length_m = travelled_m_;
    if (result_.estimates.empty() && result_.scans > 0) {
      result_.warnings.push_back(
          "no place on the map explains the scans: is it the map of this building, at the height "
          "of this "
          "laser?");
    }
    if (!result_.had_odometry && result_.scans > 0) {
      result_.warnings.push_back(
          "the log has no odometry: the robot is assumed to keep its velocity from scan to scan");
    }
    return std::move(result_);
  }

 private:
  void process_ready() {
    while (const auto scan = queue_.next()) {
      const auto start = std::chrono::steady_clock::now();
      const double searched_before = result_.search_s;
      process(*scan);
      result_.filter_s += seconds_since(start) - (result_.search_s - searched_before);
    }
  }

  void process(const LaserScan& scan) {
    if (last_stamp_ && scan.stamp <= *last_stamp_) return;
    ++result_.scans;
    const PoseWithCovariance2 motion = motion_to(scan.stamp);
    advance(motion);
    const LocalizationScan view =
        view_for_localization(scan, mount_of(scan, robot_), velocity_, options_.beams);
    if (view.points_robot.size() < kLeastReturns) {
      ++result_.scans_dropped;
    } else if (belief_.empty()) {
      start(view);
    } else if (moved_enough()) {
      weigh(view);
    }
    if (belief_.empty()) return;
    follow_best_place();
    const bool seen = view.points_robot.size() >= kLeastReturns;
    const bool refined = seen && refine(view);
    update_velocity(scan.stamp);
    LocalizationEstimate estimate = judge(view, refined);
    if (seen && options_.recover && recover(view, estimate)) {
      follow_best_place();
      estimate = judge(view, refine(view));
    }
    report(view, std::move(estimate));
  }

  /// Of the robot since the last scan, from_T_to.
  PoseWithCovariance2 motion_to(Stamp stamp) {
    PoseWithCovariance2 motion;
    const bool first = !last_stamp_;
    const Stamp from = last_stamp_.value_or(stamp);
    last_stamp_ = stamp;
    if (first) {
      first_stamp_ = stamp;
      return motion;
    }
    const double duration_s = (stamp - from).seconds();
    step_s_ = duration_s;
    if (const auto known = queue_.odometer().motion_between(from, stamp)) {
      result_.had_odometry = true;
      motion = *known;
      motion.covariance *= kOdometryFactor;
      velocity_ = log(motion.pose) / std::max(duration_s, 1e-6);
      return motion;
    }
    motion.pose = exp(Tangent2(velocity_ * duration_s));
    const double sigma_m = kUnknownSpeed * duration_s;
    const double sigma_rad = kUnknownYawRate * duration_s;
    motion.covariance.diagonal() << sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad;
    return motion;
  }

  void advance(const PoseWithCovariance2& motion) {
    travelled_m_ += motion.pose.translation().norm();
    turned_since_weighing_rad_ += std::abs(motion.pose.yaw);
    travelled_since_weighing_m_ += motion.pose.translation().norm();
    since_weighing_ = compound(since_weighing_, motion);
    since_weighing_s_ += step_s_;
    if (track_) track_->advance(motion);
  }

  [[nodiscard]] bool moved_enough() const {
    return travelled_since_weighing_m_ >= options_.update_distance_m ||
           turned_since_weighing_rad_ >= options_.update_angle_rad;
  }

  /// The first belief: around the pose given, or wherever the map explains the scan.
  void start(const LocalizationScan& view) {
    if (initial_) {
      start_around(view, *initial_);
    } else if (pace_.due(travelled_m_)) {
      belief_.add(search(view, "start"), 1.0);
    }
    if (!belief_.empty()) particles_weighed(view);
  }

  /// A pose given by hand may be wrong. Other places that explain the scan are kept in mind, as unlikely ones: where the given
  /// place is only similar to the true one, the true one wins soon.
  void start_around(const LocalizationScan& view, const InitialPose& initial) {
    constexpr double kGivenIsWrong = 1e-3;
    PoseBelief::Proposal given{.map_T_robot = {.pose = initial.map_T_robot}};
    given.map_T_robot.covariance.diagonal() << initial.sigma_m * initial.sigma_m,
        initial.sigma_m * initial.sigma_m, initial.sigma_rad * initial.sigma_rad;
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
    const Pose2& given = initial.map_T_robot;
    return std::hypot(pose.x - given.x, pose.y - given.y) < kSigmas * initial.sigma_m &&
           std::abs(wrap_angle(pose.yaw - given.yaw)) < kSigmas * initial.sigma_rad;
  }

  /// Moves the particles to now and weighs them.
  void weigh(const LocalizationScan& view) {
    const PoseWithCovariance2 motion = since_weighing_;
    Eigen::Matrix3d covariance = motion.covariance;
    covariance.diagonal() +=
        Eigen::Vector3d(kJitterM * kJitterM, kJitterM * kJitterM, kJitterRad * kJitterRad);
    if (track_) {
      // On the axes of the robot as it was when the particles were weighed last.
      const PoseWithCovariance2& now = track_->map_T_robot();
      const Eigen::Matrix2d then_R_map = (now.pose * motion.pose.inverse()).rotation().transpose();
      const Eigen::Matrix2d position = now.covariance.topLeftCorner<2, 2>();
      covariance.topLeftCorner<2, 2>() += scale_covariance(
          then_R_map * position * then_R_map.transpose(), motion.pose.translation());
    }
    if (options_.motion == "odometry") {
      const TurnGoTurn parts = turn_go_turn(motion.pose);
      belief_.predict([parts](const Pose2& pose, Rng& noise) {
        return sample_odometry_motion(pose, parts, {}, noise);
      });
    } else if (options_.motion == "velocity") {
      const Tangent2 way = log(motion.pose);
      const double duration_s = std::max(since_weighing_s_, 1e-6);
      belief_.predict([way, duration_s](const Pose2& pose, Rng& noise) {
        return sample_velocity_motion(pose, way.x() / duration_s, way.z() / duration_s, duration_s,
                                      {}, noise);
      });
    } else {
      const GaussianMotion gaussian(motion.pose, covariance);
      belief_.predict(
          [&gaussian](const Pose2& pose, Rng& noise) { return gaussian.sample(pose, noise); });
    }
    particles_weighed(view);
  }

  void particles_weighed(const LocalizationScan& view) {
    const double scale = 1.0 / kBeamsAsOne;
    const auto place_evidence = [&](const PlaceBelief& place) { return evidence_of(view, place); };
    belief_.update(
        [&](std::span<const Pose2> poses, std::span<double> out) {
          log_likelihoods(view, poses, out);
          for (double& value : out) value *= scale;
        },
        scale * static_cast<double>(view.weighed.size()), place_evidence);
    belief_.settle();
    since_weighing_ = {};
    since_weighing_s_ = 0.0;
    travelled_since_weighing_m_ = 0.0;
    turned_since_weighing_rad_ = 0.0;
  }

  void log_likelihoods(const LocalizationScan& view, std::span<const Pose2> poses,
                       std::span<double> out) {
    const LikelihoodFieldModel& model = map_.tables().weigher;
    if (options_.sensor == "beam") {
      beam_sensor_.log_likelihoods(view, poses, out, threads_);
    } else if (options_.sensor == "beam_skipping") {
      (void)model.log_likelihoods_skipping(poses, view.weighed, out, {}, threads_);
    } else {
      model.log_likelihoods(poses, view.weighed, out, threads_);
    }
  }

  /// Log-likelihood of the scan from the best of some poses.
  [[nodiscard]] double best_evidence(const LocalizationScan& view,
                                     std::span<const Pose2> poses) const {
    std::vector<double> values(poses.size());
    map_.tables().judge.log_likelihoods(poses, view.weighed, values, threads_);
    return *std::max_element(values.begin(), values.end()) / kBeamsAsOneOfPlace;
  }

  /// How well a place explains the scan: from the best of its particles, or from where registration moves their mean.
  [[nodiscard]] double evidence_of(const LocalizationScan& view, const PlaceBelief& place) const {
    constexpr std::size_t kParticles = 200;
    constexpr std::size_t kPoints = 120;
    std::vector<Pose2> poses = thinned(place.particles.states(), kParticles);
    poses.push_back(place.moments.pose);
    const MatchResult match =
        match_to_field(thinned(view.points_robot, kPoints), map_.tables().search.field(),
                       place.moments.pose, {}, 1);
    if (has_supported_pose(match.status)) poses.push_back(match.target_T_source);
    return best_evidence(view, poses);
  }

  /// Keeps the track on the most probable place.
  void follow_best_place() {
    const PlaceBelief& best = belief_.places().front();
    const PoseWithCovariance2 mean = compound(best.moments, since_weighing_);
    const bool changed = !track_ || best.id != best_id_;
    if (changed) {
      best_since_m_ = travelled_m_;
      best_id_ = best.id;
      fit_.reset();
    }
    const auto astray = [&] {
      const Pose2& pose = track_->map_T_robot().pose;
      const double spread = std::sqrt(mean.covariance.topLeftCorner<2, 2>().trace());
      return std::hypot(pose.x - mean.pose.x, pose.y - mean.pose.y) > kAstrayM + 2.0 * spread ||
             std::abs(wrap_angle(pose.yaw - mean.pose.yaw)) >
                 kAstrayRad + 2.0 * std::sqrt(mean.covariance(2, 2));
    };
    if (changed || astray()) track_.emplace(mean);
  }

  bool refine(const LocalizationScan& view) {
    return track_->refine(thinned(view.points_robot, kRefinePoints),
                          view.robot_T_lidar.translation(), map_.tables().search.field(), offset_);
  }

  void update_velocity(Stamp stamp) {
    const Pose2& pose = track_->map_T_robot().pose;
    if (!result_.had_odometry && last_pose_ && stamp > last_pose_stamp_) {
      velocity_ = log(last_pose_->inverse() * pose) / (stamp - last_pose_stamp_).seconds();
    }
    last_pose_ = pose;
    last_pose_stamp_ = stamp;
  }

  LocalizationEstimate judge(const LocalizationScan& view, bool refined) {
    const PlaceBelief& best = belief_.places().front();
    LocalizationEstimate estimate;
    estimate.stamp = *last_stamp_;
    estimate.map_T_robot = track_->map_T_robot().pose;
    estimate.covariance = track_->map_T_robot().covariance;
    estimate.refined = refined;
    estimate.hypotheses = static_cast<int>(belief_.places().size());
    estimate.particles = static_cast<int>(belief_.particle_count());
    estimate.travelled_m = travelled_m_;
    if (view.points_robot.size() >= kLeastReturns) {
      const BeamFit fit = fit_beams(view, map_, estimate.map_T_robot);
      if (!fit_) fit_ = fit;
      fit_->explained = followed(fit_->explained, fit.explained, fit.explained < fit_->explained);
      fit_->violations =
          followed(fit_->violations, fit.violations, fit.violations > fit_->violations);
      fit_->unexpected =
          followed(fit_->unexpected, fit.unexpected, fit.unexpected > fit_->unexpected);
    } else if (fit_) {
      // A scanner that sees nothing confirms nothing.
      fit_->explained *= 1.0 - kForgotten;
    }
    const BeamFit fit = fit_.value_or(BeamFit{});
    const Eigen::Matrix3d& spread = best.moments.covariance;
    estimate.evidence = {.explained = fit.explained,
                         .violations = fit.violations,
                         .unexpected = fit.unexpected,
                         .mass = mass_near(best, estimate.map_T_robot) * (1.0 - rest_share_),
                         .precision = precision_of(estimate.covariance),
                         .spread_m = std::sqrt(spread(0, 0) + spread(1, 1)),
                         .spread_rad = std::sqrt(spread(2, 2)),
                         .innovation = track_->innovation(),
                         .followed_m = travelled_m_ - best_since_m_};
    estimate.probability = pose_probability(estimate.evidence);
    // A pose that is imprecise along a corridor is not lost: it is in the right place.
    const double place_probability =
        estimate.probability / std::max(estimate.evidence.precision, 1e-9);
    estimate.state = estimate.probability >= options_.tracking_probability
                         ? LocalizationState::kTracking
                     : place_probability < options_.lost_probability ? LocalizationState::kLost
                                                                     : LocalizationState::kDoubtful;
    return estimate;
  }

  /// Belief in the particles that agree with a pose as far as their own spread lets them. A place along a corridor may be long.
  [[nodiscard]] double mass_near(const PlaceBelief& place, const Pose2& pose) const {
    constexpr double kNearM = 0.5;
    constexpr double kNearRad = 0.35;
    const Pose2 then = pose * since_weighing_.pose.inverse();
    double near = 0.0;
    for (std::size_t i = 0; i < place.particles.size(); ++i) {
      const Pose2& particle = place.particles.states()[i];
      if (std::hypot(particle.x - then.x, particle.y - then.y) < kNearM &&
          std::abs(wrap_angle(particle.yaw - then.yaw)) < kNearRad) {
        near += std::exp(place.particles.log_weights()[i]);
      }
    }
    return near * std::exp(place.log_mass);
  }

  /// Searches the map when the pose is doubted for some scans, and lets what it finds compete. True when it found something.
  bool recover(const LocalizationScan& view, const LocalizationEstimate& estimate) {
    constexpr int kDoubtedScans = 3;
    constexpr double kDoesNotFit = 0.5;
    if (estimate.state == LocalizationState::kTracking) {
      doubted_scans_ = 0;
      pace_.calm();
      return false;
    }
    // Where another place explains the scans as well, only motion can tell: no search can. But scans that don't fit, or places
    // that were too many to follow, are worth another look.
    const double fits = estimate.probability / std::max(estimate.evidence.mass, 1e-9);
    const bool worthwhile = fits < kDoesNotFit || rest_share_ > 0.0;
    doubted_scans_ = worthwhile ? doubted_scans_ + 1 : 0;
    if (doubted_scans_ < kDoubtedScans || !pace_.due(travelled_m_)) return false;
    doubted_scans_ = 0;
    const bool lost = estimate.state == LocalizationState::kLost;
    std::vector<PoseBelief::Proposal> proposals = search(view, lost ? "lost" : "doubtful");
    if (proposals.empty()) return false;
    // New places against old ones, by how well each explains this scan.
    double best_log = -std::numeric_limits<double>::infinity();
    // A robot slips by a metre more often than it is carried to a place that looks the same.
    const auto nearby = [&](const PoseBelief::Proposal& proposal) {
      return is_near(proposal.map_T_robot.pose, estimate);
    };
    const bool any_near = std::any_of(proposals.begin(), proposals.end(), nearby);
    for (auto& proposal : proposals) {
      if (any_near && !nearby(proposal)) proposal.log_mass -= kFarLogOdds;
      proposal.log_mass += best_evidence(view, std::span(&proposal.map_T_robot.pose, 1));
      best_log = std::max(best_log, proposal.log_mass);
    }
    double old_sum = 0.0;
    for (const PlaceBelief& place : belief_.places()) {
      const Pose2 now =
          place.id == best_id_ ? estimate.map_T_robot : place.moments.pose * since_weighing_.pose;
      old_sum += std::exp(place.log_mass + best_evidence(view, std::span(&now, 1)) - best_log);
    }
    double new_sum = 0.0;
    for (const auto& proposal : proposals)
      new_sum += std::exp(proposal.log_mass - best_log) / static_cast<double>(proposals.size());
    const double prior = lost ? kNewPlacesShareWhenLost : kNewPlacesShare;
    const double ratio = prior / (1.0 - prior) * new_sum / std::max(old_sum, 1e-12);
    // The particles stand where they were weighed last; move them to now before others join them.
    const GaussianMotion motion(since_weighing_.pose, since_weighing_.covariance);
    belief_.predict(
        [&motion](const Pose2& pose, Rng& noise) { return motion.sample(pose, noise); });
    since_weighing_ = {};
    since_weighing_s_ = 0.0;
    belief_.add(proposals, std::clamp(ratio / (1.0 + ratio), 1e-3, lost ? 0.98 : 0.5));
    belief_.settle();
    return true;
  }

  std::vector<PoseBelief::Proposal> search(const LocalizationScan& view, const char* reason) {
    const auto start = std::chrono::steady_clock::now();
    MapMatchOptions options;
    // A corridor alone has a place every metre, in two directions.
    options.poses_max = kPlacesMost;
    options.refined_max = 2 * kPlacesMost;
    const Pose2 lidar_T_robot = view.robot_T_lidar.inverse();
    std::vector<Eigen::Vector2d> points;
    points.reserve(view.points_robot.size());
    for (const auto& point : view.points_robot) points.push_back(lidar_T_robot * point);
    const MapMatch found = match_on_map(points, map_.tables().search, {}, options);
    LocalizationSearch record{.stamp = *last_stamp_, .reason = reason, .whole_map = true};
    record.poses_found = static_cast<int>(found.poses.size());
    std::vector<PoseBelief::Proposal> proposals;
    for (const MatchResult& match : found.poses) {
      PoseBelief::Proposal proposal{
          .map_T_robot = {match.target_T_source * lidar_T_robot, spread_of(match.covariance)}};
      if (!is_known(proposal.map_T_robot.pose)) ++record.poses_added;
      if (found.sure && !proposals.empty()) proposal.log_mass = -kSureLogOdds;
      proposals.push_back(proposal);
    }
    if (!found.poses.empty()) record.best_score = found.poses.front().score;
    rest_share_ = found.complete ? 0.0 : kRestShare;
    result_.searches.push_back(std::move(record));
    pace_.searched(travelled_m_);
    result_.search_s += seconds_since(start);
    return proposals;
  }

  /// Is a pose where the robot may be by what was believed, but for a slip of the wheels?
  [[nodiscard]] static bool is_near(const Pose2& pose, const LocalizationEstimate& estimate) {
    constexpr double kSlipM = 1.5;
    constexpr double kSlipRad = 0.6;
    constexpr double kSigmas = 4.0;
    const Pose2& believed = estimate.map_T_robot;
    const double sigma_m = std::sqrt(estimate.covariance.topLeftCorner<2, 2>().trace());
    return std::hypot(pose.x - believed.x, pose.y - believed.y) < kSlipM + kSigmas * sigma_m &&
           std::abs(wrap_angle(pose.yaw - believed.yaw)) < kSlipRad;
  }

  [[nodiscard]] bool is_known(const Pose2& pose) const {
    constexpr double kSameM = 0.5;
    constexpr double kSameRad = 0.3;
    return std::any_of(belief_.places().begin(), belief_.places().end(),
                       [&](const PlaceBelief& place) {
                         const Pose2 now = place.moments.pose * since_weighing_.pose;
                         return std::hypot(now.x - pose.x, now.y - pose.y) < kSameM &&
                                std::abs(wrap_angle(now.yaw - pose.yaw)) < kSameRad;
                       });
  }

  void report(const LocalizationScan& view, LocalizationEstimate estimate) {
    if (options_.sensor == "beam" && estimate.state == LocalizationState::kTracking)
      beam_sensor_.learn_from(view, estimate.map_T_robot);
    if (result_.changes.empty() || result_.changes.back().state != estimate.state)
      result_.changes.push_back({estimate.stamp, estimate.state});
    if (travelled_m_ >= next_snapshot_m_) take_snapshot(view, estimate);
    result_.estimates.push_back(std::move(estimate));
  }

  void take_snapshot(const LocalizationScan& view, const LocalizationEstimate& estimate) {
    constexpr std::size_t kMost = 24;
    BeliefSnapshot snapshot{.stamp = estimate.stamp, .points = view.weighed, .estimate = estimate};
    for (const PlaceBelief& place : belief_.places()) {
      snapshot.hypotheses.push_back(
          {place.moments.pose * since_weighing_.pose, std::exp(place.log_mass)});
    }
    for (const Pose2& particle : belief_.particles())
      snapshot.particles.push_back(particle * since_weighing_.pose);
    result_.snapshots.push_back(std::move(snapshot));
    if (options_.snapshot_distance_m > 0.0) {
      next_snapshot_m_ = travelled_m_ + options_.snapshot_distance_m;
      return;
    }
    // How long the run will be is not known: keep every other one when there are too many.
    if (result_.snapshots.size() == kMost) {
      std::vector<BeliefSnapshot> kept;
      for (std::size_t i = 0; i < kMost; i += 2) kept.push_back(std::move(result_.snapshots[i]));
      result_.snapshots = std::move(kept);
      snapshot_interval_m_ *= 2.0;
    }
    next_snapshot_m_ = travelled_m_ + snapshot_interval_m_;
  }

  const LocalizationMap& map_;
  RobotModel robot_;
  LocalizationOptions options_;
  std::optional<InitialPose> initial_;
  Threads threads_;
  ScanQueue queue_;
  LearnedBeamSensor beam_sensor_;
  PoseBelief belief_;

  std::optional<Stamp> first_stamp_{};
  std::optional<Stamp> last_stamp_{};
  double step_s_ = 0.0;
  Tangent2 velocity_ = Tangent2::Zero();
  std::optional<Pose2> last_pose_{};
  Stamp last_pose_stamp_{};
  double travelled_m_ = 0.0;
  PoseWithCovariance2 since_weighing_{};  // motion of the robot since the particles were weighed
  double since_weighing_s_ = 0.0;
  double travelled_since_weighing_m_ = 0.0;
  double turned_since_weighing_rad_ = 0.0;

  std::optional<PoseTrack> track_{};  // of the most probable place
  RangeOffset offset_{};
  int best_id_ = -1;
  double best_since_m_ = 0.0;
  std::optional<BeamFit> fit_{};
  int doubted_scans_ = 0;
  double rest_share_ = 0.0;
  SearchPace pace_{};

  LocalizationResult result_{};
  std::size_t handed_out_ = 0;
  double next_snapshot_m_ = 0.0;
  double snapshot_interval_m_ = 0.25;
};

Localizer::Localizer(const LocalizationMap& map, const RobotModel& robot,
                     const LocalizationOptions& options, const std::optional<InitialPose>& initial,
                     std::uint64_t seed, Threads threads)
    : impl_(std::make_unique<Impl>(map, robot, options, initial, seed, threads)) {}
Localizer::~Localizer() = default;
Localizer::Localizer(Localizer&&) noexcept = default;
Localizer& Localizer::operator=(Localizer&&) noexcept = default;

void Localizer::add(const SensorMessage& message) { impl_->add(message); }
std::optional<LocalizationEstimate> Localizer::next() { return impl_->next(); }
LocalizationResult Localizer::finish() { return impl_->finish(); }

}  // namespace loopstone
