#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <utility>

#include "loopstone/base/rng.hpp"
#include "loopstone/simulation/simulate.hpp"
#include "loopstone/simulation/surface_index.hpp"
#include "simulation/faulty_motion.hpp"
#include "simulation/laser_realism.hpp"
#include "simulation/people.hpp"
#include "simulation/reflectivity.hpp"
#include "simulation/wheel_slips.hpp"

namespace loopstone {

/// Moments of a sensor that fires at a steady rate, on whole microseconds, so that every format
/// keeps the stamps exactly.
class Clock {
 public:
  Clock(double rate_hz, double first_s) : period_s_(1.0 / rate_hz), first_s_(first_s) {}
  /// Time of firing `index` since the start of the drive [s].
  [[nodiscard]] double time_s(std::int64_t index) const;

 private:
  double period_s_;
  double first_s_;
};

/// Encoder counts of the four wheels over a drive; the fraction of a count that a reading can't
/// hold goes into the next.
class WheelSensor {
 public:
  /// \param motion  what the wheels see of the drive
  WheelSensor(FaultyMotion motion, const WheelModel& model, const SimulatedWheels& noise, Rng rng);

  /// Makes them worse, before the first reading.
  void worsen(const RealismWheels& realism, Rng rng, RealismRecord& record);

  /// Counts since the previous call (or in all, as the model says), at a later time.
  [[nodiscard]] std::array<std::int64_t, 4> read(double time_s);
  /// What the robot itself makes of its counts: odom_T_robot after the last reading.
  [[nodiscard]] const Pose2& dead_reckoning() const { return odom_T_robot_; }

 private:
  FaultyMotion motion_;
  WheelModel model_;
  SimulatedWheels noise_;
  Rng rng_;
  double left_scale_;
  double right_scale_;
  double turn_scale_;
  WheelSlips slips_{};
  double travelled_m_ = 0.0;
  std::array<double, 4> rolled_m_{};  ///< of each wheel since the start
  std::array<std::int64_t, 4> counted_{};
  Pose2 odom_T_robot_{};
};

/// Gyro and accelerometer; each sample is the mean over one period around its stamp.
class ImuSensor {
 public:
  /// \param motion  what the gyro sees of the drive's turning
  ImuSensor(const Drive& drive, FaultyMotion motion, const SimulatedImu& noise, Rng rng);

  /// Makes the gyro worse, before the first reading.
  void worsen(const RealismGyro& realism, Rng rng, RealismRecord& record);
  [[nodiscard]] ImuSample read(double time_s);

 private:
  const Drive& drive_;
  FaultyMotion motion_;
  SimulatedImu noise_;
  Rng rng_;
  double bias_rad_s_;
  double gyro_scale_ = 1.0;
  Eigen::Vector3d tilt_m_s2_;  ///< gravity that a not quite level mount leaks into the axes
};

/// Beams at their own times from a moving robot.
class LaserSensor {
 public:
  LaserSensor(const Drive& drive, const SurfaceIndex& surfaces, const Crowd& crowd,
              const LidarMount& mount, const SimulatedLaser& options, double glass, Rng rng);
  /// Makes it worse, before the first scan.
  /// \param realism  must outlive the sensor
  void worsen(LaserRealism& realism, const Realism& options);
  /// From now on scans tell how bright each beam's echo is.
  void show(Reflectivity reflectivity) { reflectivity_ = std::move(reflectivity); }
  /// A scan whose first beam leaves at this time; its stamp is for the caller to set.
  [[nodiscard]] LaserScan read(double time_s);

 private:
  [[nodiscard]] double true_range(double time_s, double angle_rad,
                                  const std::vector<Circle>& legs) const;
  [[nodiscard]] double real_range(double time_s, double angle_rad,
                                  const std::vector<Circle>& legs) const;
  [[nodiscard]] float intensity(double time_s, double angle_rad, double range_m);

  const Drive& drive_;
  const SurfaceIndex& surfaces_;
  const Crowd& crowd_;
  Pose2 robot_T_lidar_;
  SimulatedLaser options_;
  double glass_;  ///< share of the walls that return nothing
  LaserRealism* realism_ = nullptr;
  bool tells_sweep_ = true;
  std::optional<Reflectivity> reflectivity_{};
  Rng rng_;
};

}  // namespace loopstone
