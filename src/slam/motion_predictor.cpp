#include "loopstone/slam/motion_predictor.hpp"

#include <algorithm>
#include <cmath>

namespace loopstone {

namespace {

/// Wheels: share of the motion that may be wrong, and what is uncertain even at rest (stamps,
/// quantisation).
constexpr double kWheelShare = 0.15;
constexpr double kWheelRestM = 0.01;
constexpr double kWheelRestRad = 0.01;
constexpr double kWheelRadPerM = 0.03;
/// Over a longer way the errors of turns to the left and to the right cancel in part.
constexpr double kTurnShare = 0.02;
/// A velocity is the mean over so many motions.
constexpr std::size_t kSteps = 3;
/// A velocity says nothing of what comes later: after so long, and after so many of the usual times
/// between scans.
constexpr double kLongestCoastS = 1.0;
constexpr double kLongestCoastSteps = 4.0;
/// Where nothing tells how far the robot went: as fast as a person walks, either way.
constexpr double kWalkingM_s = 1.0;
constexpr double kWalkingRad_s = 1.0;
/// Motions that differ by less start the same alignment.
constexpr double kSameM = 0.05;
constexpr double kSameRad = 0.03;
/// How wrong a motion that goes on is: never less, never more, and over how many scans it is
/// learned.
constexpr double kCoastLeastM = 0.05;
constexpr double kCoastMostM = 0.3;
constexpr double kCoastLeastRad = 0.05;
constexpr double kCoastMostRad = 0.4;
constexpr double kCoastMemory = 30.0;
/// Odometry that differs from the motion so far by so many standard deviations is one of two
/// guesses.
constexpr double kUnlikely = 3.0;

Eigen::Matrix3d information_of(double sigma, double sigma_yaw) {
  return Eigen::Vector3d(1.0 / (sigma * sigma), 1.0 / (sigma * sigma),
                         1.0 / (sigma_yaw * sigma_yaw))
      .asDiagonal();
}

/// Whether two readings count from the same start.
bool comparable(const std::optional<OdometryReading>& a, const std::optional<OdometryReading>& b) {
  return a && b && a->has_translation == b->has_translation;
}

/// How wrong a motion may be that odometry tells.
ToldMotion reach_of(const Pose2& said, const OdometryReading& from, const OdometryReading& to) {
  const double travelled = std::max(std::hypot(said.x, said.y), to.path_m - from.path_m);
  const double turned = std::max(std::abs(said.yaw), to.turned_rad - from.turned_rad);
  return {said, kWheelRestM + kWheelShare * travelled,
          kWheelRestRad + kWheelShare * turned + kWheelRadPerM * travelled};
}

double distance(const Pose2& a, const Pose2& b) { return std::hypot(a.x - b.x, a.y - b.y); }
double turn(const Pose2& a, const Pose2& b) { return std::abs(wrap_angle(a.yaw - b.yaw)); }

}  // namespace

double MotionPredictor::coast_sigma_m() const { return std::sqrt(coast_variance_m2_); }
double MotionPredictor::coast_sigma_rad() const { return std::sqrt(coast_variance_rad2_); }

std::vector<Pose2> MotionPredictor::coasts(Stamp stamp) const {
  if (steps_.empty() || !last_stamp_) return {Pose2{}};
  const Tangent2& last = steps_.back().motion;
  std::vector<Pose2> motions{exp(last)};
  double seconds = 0.0;
  Tangent2 sum = Tangent2::Zero();
  for (const Step& step : steps_) {
    seconds += step.seconds;
    sum += step.motion;
  }
  const double ahead = std::clamp((stamp - *last_stamp_).seconds(), 0.0, kLongestCoastS);
  if (seconds <= 0.0) return motions;
  const Pose2 as_fast = exp(Tangent2(sum * (ahead / seconds)));
  if (distance(as_fast, motions[0]) > kSameM || turn(as_fast, motions[0]) > kSameRad)
    motions.push_back(as_fast);
  return motions;
}

bool MotionPredictor::coast_is_over(Stamp stamp) const {
  if (!last_stamp_ || steps_.empty()) return false;
  double usual_s = 0.0;
  for (const Step& step : steps_) usual_s = std::max(usual_s, step.seconds);
  const double seconds = (stamp - *last_stamp_).seconds();
  return seconds > kLongestCoastS && seconds > kLongestCoastSteps * usual_s;
}

std::vector<MotionGuess> MotionPredictor::coast_guesses(Stamp stamp) const {
  if (coast_is_over(stamp)) return {};
  const Eigen::Matrix3d loose = information_of(coast_sigma_m(), coast_sigma_rad());
  std::vector<MotionGuess> guesses;
  for (const Pose2& motion : coasts(stamp)) guesses.push_back({last_pose_ * motion, loose, false});
  return guesses;
}

std::vector<MotionGuess> MotionPredictor::guesses(
    Stamp stamp, const std::optional<OdometryReading>& odometry) const {
  if (!last_stamp_) return {{Pose2{}, information_of(1.0, 1.0), false}};
  const double blind_s = (stamp - *last_stamp_).seconds();
  const bool over = coast_is_over(stamp);
  if (!comparable(odometry, last_odometry_)) {
    if (!over) return coast_guesses(stamp);
    return {{last_pose_, information_of(kWalkingM_s * blind_s, kWalkingRad_s * blind_s), false}};
  }
  const std::vector<Pose2> going_on = over ? std::vector<Pose2>{Pose2{}} : coasts(stamp);
  std::vector<MotionGuess> guesses;
  const Pose2 said = scaled_motion(*last_odometry_, *odometry);
  const bool translates = odometry->has_translation && (!checks_ || check_.trusts_translation());
  const bool turns = !checks_ || check_.trusts_rotation();
  const ToldMotion reach = reach_of(said, *last_odometry_, *odometry);
  const double coast_m = over ? kWalkingM_s * blind_s : coast_sigma_m();
  const double coast_rad = over ? kWalkingRad_s * blind_s : coast_sigma_rad();
  const Eigen::Matrix3d information =
      information_of(translates ? reach.sigma_m : coast_m, turns ? reach.sigma_rad : coast_rad);
  if (translates && turns) {
    guesses.push_back({last_pose_ * said, information, true});
    if (!checks_) return guesses;
    const bool unlikely = std::all_of(going_on.begin(), going_on.end(), [&](const Pose2& motion) {
      return distance(said, motion) > kUnlikely * coast_sigma_m() ||
             turn(said, motion) > kUnlikely * coast_sigma_rad();
    });
    if (unlikely) {
      for (const MotionGuess& guess : coast_guesses(stamp)) guesses.push_back(guess);
    }
    return guesses;
  }
  for (const Pose2& motion : going_on) {
    const Pose2& translation = translates ? said : motion;
    const Pose2& rotation = turns ? said : motion;
    guesses.push_back(
        {last_pose_ * Pose2{translation.x, translation.y, rotation.yaw}, information, translates});
  }
  return guesses;
}

Pose2 MotionPredictor::scaled_motion(const OdometryReading& from, const OdometryReading& to) const {
  Pose2 said = from.odom_T_robot.inverse() * to.odom_T_robot;
  // Wheels that were too large wherever the laser could see it are so along a corridor too.
  const double scale = checks_ ? check_.translation().scale().value_or(1.0) : 1.0;
  said.x /= scale;
  said.y /= scale;
  return said;
}

std::optional<ToldMotion> MotionPredictor::told(const OdometryReading& from, Stamp from_stamp,
                                                const OdometryReading& to) const {
  if (!from.has_translation || !to.has_translation) return {};
  if (checks_ && !(check_.trusts_translation() && check_.trusts_rotation())) return {};
  if (to.silent_until && *to.silent_until > from_stamp) return {};
  const Pose2 motion = scaled_motion(from, to);
  const double path_m = std::max(std::hypot(motion.x, motion.y), to.path_m - from.path_m);
  const double turned = std::max(std::abs(motion.yaw), to.turned_rad - from.turned_rad);
  return ToldMotion{motion, kWheelRestM + accuracy_.sigma_m(path_m, std::hypot(motion.x, motion.y)),
                    kWheelRestRad + kTurnShare * turned + accuracy_.sigma_rad(path_m)};
}

void MotionPredictor::settle(Stamp stamp, const Pose2& local_T_robot,
                             const std::optional<OdometryReading>& odometry, Seen seen) {
  if (last_stamp_) {
    const Pose2 motion = last_pose_.inverse() * local_T_robot;
    if (comparable(odometry, last_odometry_) && checks_) {
      check_.add({.from = *last_stamp_,
                  .to = stamp,
                  .odometry = last_odometry_->odom_T_robot.inverse() * odometry->odom_T_robot,
                  .laser = motion,
                  .sees_translation = seen.translation && last_seen_.translation,
                  .sees_rotation = seen.rotation && last_seen_.rotation,
                  .odometry_has_translation = odometry->has_translation});
    }
    if (odometry && odometry->has_translation && seen.translation) {
      accuracy_.add(odometry->odom_T_robot, local_T_robot, odometry->path_m);
    } else if (!seen.rotation) {
      accuracy_.interrupt();
    }
    if (seen.rotation && !steps_.empty()) {
      // The nearer of the guesses counts: the other one was for irregular stamps.
      double off = kCoastMostM;
      double off_yaw = kCoastMostRad;
      for (const Pose2& guess : coasts(stamp)) {
        if (seen.translation) off = std::min(off, distance(guess, motion));
        off_yaw = std::min(off_yaw, turn(guess, motion));
      }
      const auto learn = [](double& variance, double error, double least, double most) {
        variance += (error * error - variance) / kCoastMemory;
        variance = std::clamp(variance, least * least, most * most);
      };
      if (seen.translation) learn(coast_variance_m2_, off, kCoastLeastM, kCoastMostM);
      learn(coast_variance_rad2_, off_yaw, kCoastLeastRad, kCoastMostRad);
    }
    if (coast_is_over(stamp)) {
      // A motion across a gap does not go on.
      steps_.clear();
    } else {
      steps_.push_back({std::max(0.0, (stamp - *last_stamp_).seconds()), log(motion)});
      if (steps_.size() > kSteps) steps_.pop_front();
    }
  }
  last_stamp_ = stamp;
  last_pose_ = local_T_robot;
  last_odometry_ = odometry;
  last_seen_ = seen;
}

}  // namespace loopstone
