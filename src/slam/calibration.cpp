#include "loopstone/slam/calibration.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/geometry/angle.hpp"
#include "slam/robust_fit.hpp"

namespace loopstone {

namespace {

/// What is thought of the unknowns before the log is asked: of no weight where it speaks.
constexpr double kTurnSigma = 0.05;
constexpr double kHeldSigma = 1e-4;  // where no motion tells scale and yaw
constexpr double kPlaceSigmaM = 0.5;
constexpr double kDelaySigmaS = 0.2;
constexpr double kScaleSigma = 0.5;
constexpr double kBiasSigmaRadS = 0.2;
constexpr double kTurnPerMetreSigma = 0.2;

/// A motion as laser and odometry tell it, in the frame of its start.
struct Motion {
  Pose2 laser{};
  Pose2 odometry{};
  double seconds = 0.0;
  /// Derivative of odometry's motion when both its ends are read later.
  Pose2 when_later{};
};

/// Forward, sideways and turning speed that odometry tells about a scan, in the robot's frame.
Tangent2 velocity_at(const std::deque<TrackedPose>& track, std::size_t index) {
  const auto usable = [&](std::size_t i) { return track[i].odom_T_robot.has_value(); };
  const std::size_t before = index > 0 && usable(index - 1) ? index - 1 : index;
  const std::size_t after = index + 1 < track.size() && usable(index + 1) ? index + 1 : index;
  const double seconds = (track[after].stamp - track[before].stamp).seconds();
  if (!(seconds > 0.0) || seconds > kCalibration.longest_span_s) return Tangent2::Zero();
  return log(track[before].odom_T_robot->inverse() * *track[after].odom_T_robot) / seconds;
}

Pose2 derivative_when_later(const Pose2& motion, const Tangent2& at_start, const Tangent2& at_end) {
  const Eigen::Vector2d end = motion.rotation() * at_end.head<2>();
  return {end.x() - at_start.x() + at_start.z() * motion.y,
          end.y() - at_start.y() - at_start.z() * motion.x, at_end.z() - at_start.z()};
}

bool meets(const Stamp& from, const Stamp& to, std::span<const TimeSpan> spans) {
  return std::ranges::any_of(
      spans, [&](const TimeSpan& span) { return from <= span.to && span.from <= to; });
}

std::vector<Motion> motions_of(const std::deque<TrackedPose>& track,
                               std::span<const TimeSpan> left_out) {
  std::vector<Motion> motions;
  std::optional<std::size_t> first;
  for (std::size_t i = 0; i < track.size(); ++i) {
    const bool follows = i > 0 && track[i].stamp > track[i - 1].stamp && track[i].odom_T_robot;
    if (!track[i].odom_T_robot) {
      first.reset();
      continue;
    }
    if (!first || !follows) {
      first = i;
      continue;
    }
    const double seconds = (track[i].stamp - track[*first].stamp).seconds();
    if (seconds < kCalibration.span_s) continue;
    const std::size_t from = *first;
    first = i;
    if (seconds > kCalibration.longest_span_s || meets(track[from].stamp, track[i].stamp, left_out))
      continue;
    Motion motion{.laser = track[from].local_T_robot.inverse() * track[i].local_T_robot,
                  .odometry = track[from].odom_T_robot->inverse() * *track[i].odom_T_robot,
                  .seconds = seconds};
    const bool moves = hypotenuse(motion.laser.x, motion.laser.y) > kCalibration.still_m ||
                       std::abs(motion.laser.yaw) > kCalibration.still_rad;
    if (!moves || !motion.laser.vector().allFinite() || !motion.odometry.vector().allFinite())
      continue;
    motion.when_later =
        derivative_when_later(motion.odometry, velocity_at(track, from), velocity_at(track, i));
    if (motion.when_later.vector().allFinite()) motions.push_back(motion);
  }
  return motions;
}

/// What the drive shows at all: of a robot that only drives straight on, noise is all that turns.
struct Excitation {
  bool drives = false;
  bool turns = false;
};

Excitation excitation_of(const std::vector<Motion>& motions) {
  double way_m = 0.0;
  double turned_rad = 0.0;
  for (const Motion& motion : motions) {
    const double length_m = hypotenuse(motion.odometry.x, motion.odometry.y);
    if (length_m > kCalibration.clear_m) way_m += length_m;
    if (std::abs(motion.laser.yaw) > kCalibration.clear_rad)
      turned_rad += std::abs(motion.laser.yaw);
  }
  return {way_m > kCalibration.enough_m, turned_rad > kCalibration.enough_rad};
}

/// x = (rotation scale, bias, turn a metre, delay): odometry's turn = scale * laser's + bias * time
/// + turn a metre * way - delay * derivative.
LinearProblem turning_problem(const std::vector<Motion>& motions) {
  const auto count = static_cast<Eigen::Index>(motions.size());
  LinearProblem problem{
      Eigen::MatrixXd(count, 4), Eigen::VectorXd(count), 1, Eigen::Vector4d(1.0, 0.0, 0.0, 0.0),
      Eigen::Vector4d(kScaleSigma, kBiasSigmaRadS, kTurnPerMetreSigma, kDelaySigmaS)};
  for (Eigen::Index i = 0; i < count; ++i) {
    const Motion& motion = motions[static_cast<std::size_t>(i)];
    problem.a.row(i) << motion.laser.yaw, motion.seconds, motion.odometry.x, -motion.when_later.yaw;
    problem.y[i] = motion.laser.yaw + wrap_angle(motion.odometry.yaw - motion.laser.yaw);
  }
  return problem;
}

/// x = (s cos, s sin, s dx, s dy, delay), see calibrate().
/// \param share  of the heading's error by which odometry's motion is turned
LinearProblem driving_problem(const std::vector<Motion>& motions, const Excitation& shown,
                              double turning_delay_s, double share) {
  const auto count = static_cast<Eigen::Index>(motions.size());
  LinearProblem problem{Eigen::MatrixXd(2 * count, 5), Eigen::VectorXd(2 * count), 2,
                        Eigen::VectorXd::Unit(5, 0), Eigen::VectorXd(5)};
  const double turn_sigma = shown.drives ? kTurnSigma : kHeldSigma;
  problem.prior_sigma << turn_sigma, turn_sigma, kPlaceSigmaM, kPlaceSigmaM, kDelaySigmaS;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Motion& motion = motions[static_cast<std::size_t>(i)];
    const double lost = wrap_angle(motion.odometry.yaw - motion.laser.yaw +
                                   turning_delay_s * motion.when_later.yaw);
    const double c = std::cos(motion.laser.yaw);
    const double s = std::sin(motion.laser.yaw);
    auto rows = problem.a.middleRows<2>(2 * i);
    rows << motion.laser.x, -motion.laser.y, 1.0 - c, s, -motion.when_later.x,  //
        motion.laser.y, motion.laser.x, -s, 1.0 - c, -motion.when_later.y;
    problem.y.segment<2>(2 * i) = Eigen::Rotation2Dd(-share * lost) * motion.odometry.translation();
  }
  return problem;
}

/// (yaw, scale, dx, dy, delay) from x of driving_problem, with its covariance.
struct Driving {
  Eigen::VectorXd value{};
  Eigen::MatrixXd covariance{};
};

Driving driving_of(const LinearFit& fit) {
  const double a = fit.x[0];
  const double b = fit.x[1];
  const double scale = std::max(hypotenuse(a, b), 1e-9);
  Driving driving{Eigen::VectorXd(5), {}};
  driving.value << std::atan2(b, a), scale, fit.x[2] / scale, fit.x[3] / scale, fit.x[4];
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(5, 5);
  jacobian.row(0).head<2>() << -b / (scale * scale), a / (scale * scale);
  jacobian.row(1).head<2>() << a / scale, b / scale;
  for (Eigen::Index i = 2; i < 4; ++i) {
    jacobian.row(i) = -driving.value[i] / scale * jacobian.row(1);
    jacobian(i, i) = 1.0 / scale;
  }
  jacobian(4, 4) = 1.0;
  driving.covariance = jacobian * fit.covariance * jacobian.transpose();
  return driving;
}

void widen(const Eigen::VectorXd& factors, Eigen::MatrixXd& covariance) {
  covariance = factors.asDiagonal() * covariance * factors.asDiagonal();
}

/// Way driven per time, of those motions that go somewhere.
double usual_speed_m_s(const std::vector<Motion>& motions) {
  double way = 0.0;
  double seconds = 0.0;
  for (const Motion& motion : motions) {
    way += hypotenuse(motion.laser.x, motion.laser.y);
    seconds += motion.seconds;
  }
  return way / seconds;
}

CalibratedValue value_of(double value, double variance, double given, double known) {
  const double sigma = std::sqrt(std::max(variance, 0.0));
  return {value, sigma, given, sigma < known};
}

/// Whether each half asks for enough of what the whole asks for.
struct Halves {
  bool yaw = false;
  bool place = false;
};

Halves agreement_of_halves(const LinearProblem& problem, const Driving& whole) {
  const Eigen::Index middle = problem.observations() / 2;
  Halves agree{true, true};
  const Eigen::Vector2d place = whole.value.segment<2>(2);
  for (const auto& half :
       {problem.part(0, middle), problem.part(middle, problem.observations() - middle)}) {
    const Driving part = driving_of(robust_fit(half));
    agree.yaw = agree.yaw && part.value[0] * whole.value[0] >
                                 kCalibration.half_agrees * whole.value[0] * whole.value[0];
    agree.place = agree.place && part.value.segment<2>(2).dot(place) >
                                     kCalibration.half_agrees * place.squaredNorm();
  }
  return agree;
}

/// Estimate of the driving part; its covariance tells what residuals, stretches of the log and the
/// way in which headings are lost say of it.
Driving driving_by(const std::vector<Motion>& motions, const Excitation& shown,
                   const LinearProblem& problem, double turning_delay_s) {
  Driving driving = driving_of(robust_fit(problem));
  widen(scatter_of_blocks(problem, kCalibration.blocks), driving.covariance);
  const Driving plain =
      driving_of(robust_fit(driving_problem(motions, shown, turning_delay_s, 0.0)));
  const Eigen::VectorXd doubt = 0.5 * (plain.value - driving.value);
  driving.covariance.diagonal() += doubt.cwiseAbs2();
  const double along_delay_m =
      kCalibration.delay_share * std::abs(driving.value[4]) * usual_speed_m_s(motions);
  driving.covariance.diagonal().segment<2>(2).array() += along_delay_m * along_delay_m;
  return driving;
}

void set_turning(const LinearProblem& problem, const LinearFit& fit, const Excitation& shown,
                 Calibration& result) {
  Eigen::MatrixXd covariance = fit.covariance;
  widen(scatter_of_blocks(problem, kCalibration.blocks), covariance);
  result.rotation_scale = value_of(fit.x[0], covariance(0, 0), 1.0, kCalibration.scale_known);
  result.rotation_scale.observable = result.rotation_scale.observable && shown.turns;
  result.turn_bias_rad_s = value_of(fit.x[1], covariance(1, 1), 0.0, kCalibration.bias_known_rad_s);
  result.laser_delay_s = value_of(fit.x[3], covariance(3, 3), 0.0, kCalibration.delay_known_s);
  result.turn_per_m_rad = value_of(fit.x[2], covariance(2, 2), 0.0, kCalibration.bias_known_rad_s);
}

void set_mount(const Driving& driving, const Excitation& shown, Calibration& result) {
  const Pose2& given = result.robot_T_lidar_given;
  const Pose2 correction{driving.value[2], driving.value[3], driving.value[0]};
  const Pose2 mount = correction * given;
  // Of (x, y, yaw) by (yaw, dx, dy) of the correction.
  const Eigen::Vector2d arm = correction.rotation() * given.translation();
  Eigen::Matrix<double, 3, 5> jacobian = Eigen::Matrix<double, 3, 5>::Zero();
  jacobian.col(0) << -arm.y(), arm.x(), 1.0;
  jacobian(0, 2) = jacobian(1, 3) = 1.0;
  result.lidar_covariance = jacobian * driving.covariance * jacobian.transpose();
  const auto& c = result.lidar_covariance;
  result.lidar_x_m = value_of(mount.x, c(0, 0), given.x, kCalibration.place_known_m);
  result.lidar_y_m = value_of(mount.y, c(1, 1), given.y, kCalibration.place_known_m);
  result.lidar_yaw_rad = value_of(mount.yaw, c(2, 2), given.yaw, kCalibration.yaw_known_rad);
  for (CalibratedValue* value : {&result.lidar_x_m, &result.lidar_y_m})
    value->observable = value->observable && shown.turns;
  result.lidar_yaw_rad.observable = result.lidar_yaw_rad.observable && shown.drives;
}

/// Turns tell the delay as well as the way does; the better of them counts more.
void set_delay(const Driving& driving, Calibration& result) {
  const CalibratedValue& by_turns = result.laser_delay_s;
  const double weight = 1.0 / std::max(by_turns.sigma * by_turns.sigma, 1e-12);
  const double other = 1.0 / std::max(driving.covariance(4, 4), 1e-12);
  const double mean = (weight * by_turns.value + other * driving.value[4]) / (weight + other);
  result.laser_delay_s = value_of(mean, 1.0 / (weight + other), 0.0, kCalibration.delay_known_s);
}

bool is_off(const CalibratedValue& value, double difference, double least) {
  return value.observable &&
         std::abs(difference) > std::max(kCalibration.sigmas * value.sigma, least);
}

bool place_is_off(const CalibratedValue& value) {
  return is_off(value, value.value - value.given, kCalibration.place_off_m);
}

/// A scale by which odometry can be calibrated by the laser at all.
bool is_likely(double scale) {
  return scale > kCalibration.scale_least && scale < kCalibration.scale_most;
}

/// How much the laser turned, and how its turns go with odometry's.
struct TurnsTogether {
  double turned_rad = 0.0;
  double correlation = 0.0;
};

/// A turn that is clear counts as one that is just so: a pose that leapt is one among many.
TurnsTogether turns_together(std::span<const Motion> motions) {
  const auto turn_of = [](const Pose2& motion) {
    return std::clamp(motion.yaw, -kCalibration.clear_rad, kCalibration.clear_rad);
  };
  double both = 0.0;
  double laser = 0.0;
  double odometry = 0.0;
  TurnsTogether result;
  for (const Motion& motion : motions) {
    both += turn_of(motion.laser) * turn_of(motion.odometry);
    laser += turn_of(motion.laser) * turn_of(motion.laser);
    odometry += turn_of(motion.odometry) * turn_of(motion.odometry);
    result.turned_rad += std::abs(motion.laser.yaw);
  }
  result.correlation = both / std::sqrt(std::max(laser * odometry, 1e-300));
  return result;
}

/// All in all, and in each stretch of the log that turns enough to show it.
bool all_turns_opposite(std::span<const Motion> motions) {
  if (turns_together(motions).correlation > -kCalibration.opposite) return false;
  const auto blocks = static_cast<std::size_t>(kCalibration.blocks);
  for (std::size_t block = 0; block < blocks; ++block) {
    const std::size_t first = block * motions.size() / blocks;
    const std::size_t end = (block + 1) * motions.size() / blocks;
    const TurnsTogether turns = turns_together(motions.subspan(first, end - first));
    if (turns.turned_rad * kCalibration.blocks < kCalibration.enough_rad) continue;
    if (turns.correlation > -kCalibration.opposite_in_part) return false;
  }
  return true;
}

/// Which way odometry turns is known long before how far.
bool turns_opposite(std::span<const Motion> motions, const LinearFit& turned) {
  const double scale = turned.x[0];
  return is_likely(-scale) && -scale > kCalibration.sigmas * std::sqrt(turned.covariance(0, 0)) &&
         all_turns_opposite(motions);
}

}  // namespace

Pose2 Calibration::robot_T_lidar() const {
  Pose2 mount = robot_T_lidar_given;
  if (yaw_is_off) mount.yaw = lidar_yaw_rad.value;
  if (place_is_off) {
    mount.x = lidar_x_m.value;
    mount.y = lidar_y_m.value;
  }
  return mount;
}

bool turns_agree(const std::deque<TrackedPose>& track) {
  const TurnsTogether turns = turns_together(motions_of(track, {}));
  return turns.turned_rad >= kCalibration.enough_rad && turns.correlation > 0.0;
}

Calibration calibrate(const std::deque<TrackedPose>& track, const Pose2& robot_T_lidar,
                      std::span<const TimeSpan> left_out) {
  Calibration result;
  result.robot_T_lidar_given = robot_T_lidar;
  const std::vector<Motion> motions = motions_of(track, left_out);
  if (motions.size() < static_cast<std::size_t>(kCalibration.fewest_motions)) return result;
  const Excitation shown = excitation_of(motions);
  const LinearProblem turning = turning_problem(motions);
  const LinearFit turned = robust_fit(turning);
  const LinearProblem problem = driving_problem(motions, shown, turned.x[3], 0.5);
  const Driving driving = driving_by(motions, shown, problem, turned.x[3]);
  result.turns_opposite = turns_opposite(motions, turned);
  if ((shown.turns && !is_likely(turned.x[0])) || !is_likely(driving.value[1])) return result;

  result.motions = static_cast<std::int64_t>(motions.size());
  set_turning(turning, turned, shown, result);
  set_mount(driving, shown, result);
  result.translation_scale =
      value_of(driving.value[1], driving.covariance(1, 1), 1.0, kCalibration.scale_known);
  result.translation_scale.observable = result.translation_scale.observable && shown.drives;
  set_delay(driving, result);
  const Halves agree = agreement_of_halves(problem, driving);
  const double yaw_off_rad = wrap_angle(result.lidar_yaw_rad.value - robot_T_lidar.yaw);
  result.yaw_is_off =
      agree.yaw && is_off(result.lidar_yaw_rad, yaw_off_rad, kCalibration.yaw_off_rad);
  result.place_is_off = agree.place && result.lidar_x_m.observable && result.lidar_y_m.observable &&
                        (place_is_off(result.lidar_x_m) || place_is_off(result.lidar_y_m));
  return result;
}

}  // namespace loopstone
