#include "simulation/sensor_models.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "simulation/systematic.hpp"

namespace loopstone {
namespace {

constexpr double kGravity = 9.80665;  ///< [m/s^2]

/// Whether the place that a beam meets is glass: the same places for every scan and every seed.
bool is_glass(const Eigen::Vector2d& point, double share) {
  constexpr double kPaneM = 0.5;
  if (share <= 0.0 || !point.allFinite()) return false;
  const auto index = [](double at) { return static_cast<std::int64_t>(std::floor(at / kPaneM)); };
  Rng pane(static_cast<std::uint64_t>(index(point.x()) * 1'000'003 + index(point.y())));
  return pane.uniform() < share;
}

/// A count as a register of that many bits shows it.
std::int64_t wrapped(std::int64_t count, int bits) {
  if (bits <= 0 || bits >= 63) return count;
  const std::int64_t size = std::int64_t{1} << bits;
  const std::int64_t rest = ((count % size) + size) % size;
  return rest >= size / 2 ? rest - size : rest;
}

}  // namespace

double Clock::time_s(std::int64_t index) const {
  return std::round((first_s_ + static_cast<double>(index) * period_s_) * 1e6) * 1e-6;
}

WheelSensor::WheelSensor(FaultyMotion motion, const WheelModel& model, const SimulatedWheels& noise,
                         Rng rng)
    : motion_(motion), model_(model), noise_(noise), rng_(rng) {
  const double scale = systematic(noise.scale_error, rng_);
  const double imbalance = systematic(noise.imbalance, rng_);
  left_scale_ = (1.0 + scale) * (1.0 - 0.5 * imbalance);
  right_scale_ = (1.0 + scale) * (1.0 + 0.5 * imbalance);
  turn_scale_ = 1.0 + systematic(noise.turn_slip, rng_);
}

void WheelSensor::worsen(const RealismWheels& realism, Rng rng, RealismRecord& record) {
  const double scale = 1.0 + systematic(realism.scale_error, rng);
  const double imbalance = systematic(realism.imbalance, rng);
  left_scale_ *= scale * (1.0 - 0.5 * imbalance);
  right_scale_ *= scale * (1.0 + 0.5 * imbalance);
  slips_ = WheelSlips(realism, rng.fork(1));
  record.facts.push_back({"wheels", "left_scale", left_scale_});
  record.facts.push_back({"wheels", "right_scale", right_scale_});
}

std::array<std::int64_t, 4> WheelSensor::read(double time_s) {
  FaultyMotion::Motion motion = motion_.until(time_s);
  travelled_m_ += motion.travelled_m;
  const WheelSlips::Slip slip = slips_.since(time_s, travelled_m_);
  motion.travelled_m += slip.ahead_m;
  motion.turned_rad += slip.turned_rad;
  const double ahead = motion.travelled_m;
  // The track is an effective one, found by turning the robot, so it has absorbed the wheels'
  // common error.
  const double aside = 0.5 * model_.track_width_m * turn_scale_ * motion.turned_rad;
  const double right = right_scale_ * ahead + aside;
  const double left = left_scale_ * ahead - aside;
  const std::array<double, 4> rolls{right, left, right,
                                    left};  // front right, front left, rear right, rear left
  std::array<std::int64_t, 4> counts{};
  std::array<double, 4> seen_m{};
  for (std::size_t wheel = 0; wheel < 4; ++wheel) {
    const double spread = noise_.slip_m_per_sqrt_m * std::sqrt(std::abs(rolls[wheel]));
    rolled_m_[wheel] += rolls[wheel] + rng_.normal(0.0, 1.0) * spread;
    const auto total =
        static_cast<std::int64_t>(std::floor(rolled_m_[wheel] / model_.metres_per_count));
    const std::int64_t since = total - counted_[wheel];
    counted_[wheel] = total;
    seen_m[wheel] = static_cast<double>(since) * model_.metres_per_count;
    counts[wheel] = model_.counts_are_cumulative ? wrapped(total, model_.counter_bits) : since;
  }
  const double seen_right = 0.5 * (seen_m[0] + seen_m[2]);
  const double seen_left = 0.5 * (seen_m[1] + seen_m[3]);
  odom_T_robot_ = odom_T_robot_ * exp(Tangent2(0.5 * (seen_right + seen_left), 0.0,
                                               (seen_right - seen_left) / model_.track_width_m));
  return counts;
}

ImuSensor::ImuSensor(const Drive& drive, FaultyMotion motion, const SimulatedImu& noise, Rng rng)
    : drive_(drive),
      motion_(motion),
      noise_(noise),
      rng_(rng),
      bias_rad_s_(systematic(noise.bias_rad_s, rng_)) {
  // Half a degree off level leaks 0.085 m/s^2 of gravity; it is noise of the mount, so none without
  // noise.
  const double leak = noise.acceleration_noise_m_s2;
  tilt_m_s2_ = {systematic(leak, rng_), systematic(leak, rng_), 0.0};
}

void ImuSensor::worsen(const RealismGyro& realism, Rng rng, RealismRecord& record) {
  gyro_scale_ = 1.0 + systematic(realism.scale_error, rng);
  bias_rad_s_ += systematic(realism.bias_rad_s, rng);
  record.facts.push_back({"gyro", "scale", gyro_scale_});
  record.facts.push_back({"gyro", "bias_rad_s", bias_rad_s_});
}

ImuSample ImuSensor::read(double time_s) {
  const double period = 1.0 / noise_.rate_hz;
  const double from = time_s - 0.5 * period;
  const double to = time_s + 0.5 * period;
  const double yaw_rate = motion_.yaw_rate(time_s, period);
  const double speed = (drive_.travelled_m(to) - drive_.travelled_m(from)) / period;
  // The drive changes its speed in steps; over five of them the difference is what a body with mass
  // would feel.
  constexpr double kSpan = 5.0 * Drive::kStep;
  const double gain =
      (drive_.speed_m_s(time_s + 0.5 * kSpan) - drive_.speed_m_s(time_s - 0.5 * kSpan)) / kSpan;
  // A random walk reaches the standard deviation that is given for 60 s.
  bias_rad_s_ += rng_.normal(0.0, 1.0) * noise_.bias_drift_rad_s * std::sqrt(period / 60.0);
  const auto noise = [&](double size) { return rng_.normal(0.0, 1.0) * size; };
  ImuSample sample;
  const double roll_rate = noise(noise_.noise_rad_s);
  const double pitch_rate = noise(noise_.noise_rad_s);
  sample.angular_velocity_rad_s = {
      roll_rate, pitch_rate, gyro_scale_ * yaw_rate + bias_rad_s_ + noise(noise_.noise_rad_s)};
  const double x = noise(noise_.acceleration_noise_m_s2);
  const double y = noise(noise_.acceleration_noise_m_s2);
  const double z = noise(noise_.acceleration_noise_m_s2);
  sample.linear_acceleration_m_s2 =
      Eigen::Vector3d(gain + x, speed * yaw_rate + y, kGravity + z) + tilt_m_s2_;
  return sample;
}

LaserSensor::LaserSensor(const Drive& drive, const SurfaceIndex& surfaces, const Crowd& crowd,
                         const LidarMount& mount, const SimulatedLaser& options, double glass,
                         Rng rng)
    : drive_(drive),
      surfaces_(surfaces),
      crowd_(crowd),
      robot_T_lidar_(mount.robot_T_lidar),
      options_(options),
      glass_(glass),
      rng_(rng) {}

double LaserSensor::true_range(double time_s, double angle_rad,
                               const std::vector<Circle>& legs) const {
  const Pose2 map_T_lidar = drive_.pose_at(time_s) * robot_T_lidar_;
  const double bearing = map_T_lidar.yaw + angle_rad;
  const Eigen::Vector2d origin = map_T_lidar.translation();
  const Eigen::Vector2d direction(std::cos(bearing), std::sin(bearing));
  double range = surfaces_.cast(origin, direction, options_.range_max_m);
  if (is_glass(origin + range * direction, glass_)) range = std::numeric_limits<double>::infinity();
  for (const Circle& leg : legs) range = std::min(range, range_to(leg, origin, direction));
  return range <= options_.range_max_m ? range : std::numeric_limits<double>::infinity();
}

void LaserSensor::worsen(LaserRealism& realism, const Realism& options) {
  realism_ = &realism;
  robot_T_lidar_ = realism.robot_T_lidar();
  if (options.sweep.on) {
    options_.sweep_s = options.sweep.sweep_s;
    tells_sweep_ = false;
  }
  // What a cover returns is in the log, so the laser is one that sees as near.
  if (options.blocked.on)
    options_.range_min_m = std::min(options_.range_min_m, options.blocked.nearest_m);
}

double LaserSensor::real_range(double time_s, double angle_rad,
                               const std::vector<Circle>& legs) const {
  const BeamEcho met = realism_->meet(time_s, angle_rad, options_.range_max_m, legs);
  const double range = realism_->measured(met);
  if (glass_ <= 0.0 || met.surface == SurfaceHit::kNothing) return range;
  const Pose2 map_T_lidar = drive_.pose_at(time_s) * robot_T_lidar_;
  const double bearing = map_T_lidar.yaw + angle_rad;
  const Eigen::Vector2d direction(std::cos(bearing), std::sin(bearing));
  const bool is_pane = is_glass(map_T_lidar.translation() + met.range_m * direction, glass_);
  return is_pane ? std::numeric_limits<double>::infinity() : range;
}

float LaserSensor::intensity(double time_s, double angle_rad, double range_m) {
  const Pose2 map_T_lidar = drive_.pose_at(time_s) * robot_T_lidar_;
  return reflectivity_->intensity(map_T_lidar.translation(), map_T_lidar.yaw + angle_rad, range_m);
}

LaserScan LaserSensor::read(double time_s) {
  LaserScan scan;
  scan.angle_min_rad = -0.5 * options_.fov_rad;
  scan.angle_increment_rad = options_.fov_rad / (options_.beams - 1);
  scan.range_min_m = options_.range_min_m;
  scan.range_max_m = options_.range_max_m;
  const double between_beams_s = options_.sweep_s / (options_.beams - 1);
  scan.time_increment_s = tells_sweep_ ? between_beams_s : 0.0;
  scan.ranges_m.resize(static_cast<std::size_t>(options_.beams));
  if (reflectivity_) scan.intensities.resize(scan.ranges_m.size());
  // Within a sweep nobody gets far; legs stand where they are in its middle.
  std::vector<Circle> legs = crowd_.legs_at(time_s + 0.5 * options_.sweep_s);
  if (realism_ != nullptr) realism_->add_people(time_s + 0.5 * options_.sweep_s, legs);
  for (std::size_t beam = 0; beam < scan.ranges_m.size(); ++beam) {
    const double beam_s = time_s + static_cast<double>(beam) * between_beams_s;
    double range = realism_ == nullptr ? true_range(beam_s, scan.angle_rad(beam), legs)
                                       : real_range(beam_s, scan.angle_rad(beam), legs);
    if (reflectivity_) scan.intensities[beam] = intensity(beam_s, scan.angle_rad(beam), range);
    // The same draws for every beam, whatever it meets: one change in a world changes nothing
    // elsewhere.
    const double noise = rng_.normal(0.0, 1.0) * options_.noise_m;
    const bool is_dropped = rng_.uniform() < options_.dropout_probability;
    if (std::isfinite(range)) {
      range += noise;
      if (range > options_.range_max_m) range = std::numeric_limits<double>::infinity();
    }
    if (is_dropped || range < options_.range_min_m)
      range = std::numeric_limits<double>::quiet_NaN();
    scan.ranges_m[beam] = static_cast<float>(range);
  }
  if (realism_ != nullptr) realism_->spoil(scan, time_s);
  return scan;
}

}  // namespace loopstone
