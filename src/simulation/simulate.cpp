#include "loopstone/simulation/simulate.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/option_list.hpp"
#include "simulation/laser_realism.hpp"
#include "simulation/message_faults.hpp"
#include "simulation/planned_drive.hpp"
#include "simulation/rgbd_sensor.hpp"
#include "simulation/sensor_models.hpp"
#include "simulation/systematic.hpp"

namespace loopstone {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

// Streams of the seed; each sensor draws from its own, so that one can be changed without the
// others.
enum Stream : std::uint64_t {
  kClocks = 10,
  kWheels,
  kImu,
  kLaser,
  kPeople,
  kCamera,
  kFaults,
  kGleam
};

/// Fires the sensors one after the other, by their stamps.
class Simulator {
 public:
  Simulator(const World& world, const Drive& drive, const RobotModel& robot,
            const SimulationOptions& options, std::uint64_t seed, const SimulationSink& sink)
      : drive_(drive),
        options_(options),
        sink_(sink),
        surfaces_(world.plan),
        crowd_(world, drive, options.people, Rng(seed).fork(kPeople)),
        motion_(drive, options.faults, Rng(seed).fork(kFaults)),
        drops_(Rng(seed).fork(kFaults).fork(1)),
        wheels_(motion_, robot.wheels, options.wheels, Rng(seed).fork(kWheels)),
        imu_(drive, motion_, options.imu, Rng(seed).fork(kImu)),
        laser_(drive, surfaces_, crowd_, mount_of_file(robot), options.laser, options.faults.glass,
               Rng(seed).fork(kLaser)),
        loss_(options.realism.loss, drive.duration_s(), realism_stream(seed, "loss")) {
    if (!realism_names(options.realism).empty()) worsen(world, robot, seed);
    if (!world.reflectors.empty()) {
      laser_.show(Reflectivity(world.reflectors, Rng(seed).fork(kGleam)));
    }
    if (sink.frame) {
      const Rng camera = Rng(seed).fork(kCamera);
      Rng phase = camera.fork(1);
      camera_clock_ =
          Clock(options.camera.rate_hz, 0.05 + phase.uniform() / options.camera.rate_hz);
      camera_.emplace(world, drive, surfaces_, crowd_, true_camera(robot.camera, options.camera),
                      options.camera, camera.fork(2));
    }
    // Nobody starts the sensors at the same moment.
    Rng phases = Rng(seed).fork(kClocks);
    wheel_clock_ = Clock(options.wheels.rate_hz, phases.uniform() / options.wheels.rate_hz);
    imu_clock_ = Clock(options.imu.rate_hz, phases.uniform() / options.imu.rate_hz);
    laser_clock_ = Clock(options.laser.rate_hz, 0.05 + phases.uniform() / options.laser.rate_hz);
    read_wheels();
    await_imu();
    await_laser();
  }

  SimulationSummary run() {
    while (true) {
      const double wheel = wheel_stamp_;
      const double imu = options_.odometry_poses ? kNever : imu_stamp_;
      const double laser = laser_stamp_;
      const double frame =
          camera_ ? camera_clock_.time_s(camera_index_) + options_.camera.clock_offset_s : kNever;
      const double next = std::min({wheel, imu, laser, frame});
      if (next > drive_.duration_s()) break;
      if (next == wheel) {
        emit_wheels();
      } else if (next == imu) {
        emit_imu();
      } else if (next == frame) {
        take_frame();
      } else if (!fire_laser(laser)) {
        summary_.complete = false;
        break;
      }
    }
    return summary_;
  }

 private:
  [[nodiscard]] static LidarMount mount_of_file(const RobotModel& robot) {
    return robot.lidars.empty() ? LidarMount{} : robot.lidars.front();
  }

  /// Turns on what `realism` asks for.
  void worsen(const World& world, const RobotModel& robot, std::uint64_t seed) {
    const Realism& realism = options_.realism;
    RealismRecord& record = summary_.realism;
    laser_realism_.emplace(world, drive_, surfaces_, robot, mount_of_file(robot), realism, seed);
    laser_.worsen(*laser_realism_, realism);
    laser_realism_->note(record);
    if (realism.wheels.on) wheels_.worsen(realism.wheels, realism_stream(seed, "wheels"), record);
    if (realism.gyro.on) imu_.worsen(realism.gyro, realism_stream(seed, "gyro"), record);
    loss_.note(record);
    note_carries(record);
    keep_spoils_within(record);
    if (!realism.stamps.on) return;
    Rng rng = realism_stream(seed, "stamps");
    const double drift = systematic(1e-6 * realism.stamps.drift_ppm, rng);
    record.facts.push_back({"stamps", "laser_clock_drift_ppm", 1e6 * drift});
    wheel_stamps_ = StampErrors(realism.stamps, 0.0, 0.0, rng.fork(1));
    imu_stamps_ = StampErrors(realism.stamps, 0.0, 0.0, rng.fork(2));
    laser_stamps_ = StampErrors(realism.stamps, realism.stamps.latency_s, drift, rng.fork(3));
  }

  void note_carries(RealismRecord& record) const {
    for (const Carry& carry : drive_.carries()) {
      const std::string name = carry.is_blind ? "carried_blind" : "carried";
      const Pose2 moved = drive_.pose_at(carry.from_s).inverse() * drive_.pose_at(carry.to_s);
      record.facts.push_back({name, "distance_m", moved.translation().norm()});
      record.facts.push_back({name, "turn_rad", moved.yaw});
      record.spoils.push_back({name, carry.from_s, carry.to_s});
    }
  }

  /// What would come after the drive's end does not come.
  void keep_spoils_within(RealismRecord& record) const {
    const double end = drive_.duration_s();
    std::erase_if(record.spoils, [&](const RealismSpoil& spoil) { return spoil.from_s >= end; });
    for (RealismSpoil& spoil : record.spoils) spoil.to_s = std::min(spoil.to_s, end);
  }

  [[nodiscard]] Stamp stamp(double time_s) const {
    return Stamp::from_seconds(options_.start_s) + Duration::from_seconds(time_s);
  }

  void emit(SensorMessage message) {
    ++summary_.messages;
    if (sink_.message) sink_.message(std::move(message));
  }

  /// Reads ahead: dead reckoning at a scan's stamp lies between two readings.
  void read_wheels() {
    odom_T_previous_ = wheels_.dead_reckoning();
    wheel_time_ = wheel_clock_.time_s(wheel_index_++);
    counts_ = wheels_.read(wheel_time_);
    previous_stamp_ = wheel_stamp_;
    wheel_stamp_ = wheel_stamps_.stamp_s(wheel_time_);
  }

  void emit_wheels() {
    const bool is_lost = loss_.is_odometry_lost(wheel_time_);
    if (is_lost || !motion_.is_read(wheel_time_)) {
      // Nobody reads the wheels.
    } else if (options_.odometry_poses) {
      emit(OdometryPose{stamp(wheel_stamp_), wheels_.dead_reckoning()});
    } else {
      emit(WheelTicks{stamp(wheel_stamp_), counts_});
    }
    read_wheels();
  }

  void await_imu() { imu_stamp_ = imu_stamps_.stamp_s(imu_clock_.time_s(imu_index_)); }

  void emit_imu() {
    const double time = imu_clock_.time_s(imu_index_++);
    ImuSample sample = imu_.read(time);
    sample.stamp = stamp(imu_stamp_);
    if (!loss_.is_odometry_lost(time)) emit(std::move(sample));
    await_imu();
  }

  void await_laser() {
    laser_stamp_ =
        laser_stamps_.stamp_s(laser_clock_.time_s(laser_index_) + options_.laser.clock_offset_s);
  }

  [[nodiscard]] bool is_carried_blind(double time_s) const {
    return std::ranges::any_of(drive_.carries(), [&](const Carry& carry) {
      return carry.is_blind && time_s >= carry.from_s && time_s < carry.to_s;
    });
  }

  void take_frame() {
    const SimulatedCamera& camera = options_.camera;
    const double time = camera_clock_.time_s(camera_index_);
    const double colour_time = time + camera.colour.lag_s;
    SimulatedFrame frame{camera_index_++, stamp(time + camera.clock_offset_s),
                         stamp(colour_time + camera.clock_offset_s), camera_->depth_at(time),
                         camera_->colour_at(colour_time)};
    ++summary_.frames;
    emit(sink_.frame(frame));
  }

  bool fire_laser(double stamp_s) {
    const double time = laser_clock_.time_s(laser_index_++);
    const bool is_fault = drops_.uniform() < options_.faults.scans_dropped;
    const bool is_lost = loss_.is_scan_lost(time);
    const bool is_dropped = is_fault || is_lost || is_carried_blind(time);
    await_laser();
    if (options_.odometry_poses && motion_.is_read(stamp_s) && !is_dropped) {
      const double span = wheel_stamp_ - previous_stamp_;
      const double ratio = span > 0.0 ? (stamp_s - previous_stamp_) / span : 0.0;
      emit(OdometryPose{stamp(stamp_s),
                        interpolate(odom_T_previous_, wheels_.dead_reckoning(), ratio)});
    }
    LaserScan scan = laser_.read(time);
    scan.stamp = stamp(stamp_s);
    if (!is_dropped) {
      ++summary_.scans;
      if (sink_.truth) sink_.truth({scan.stamp, drive_.pose_at(time)});
      emit(std::move(scan));
    }
    summary_.duration_s = stamp_s;
    summary_.route_length_m = drive_.travelled_m(time);
    return !sink_.progress || sink_.progress(time, drive_.duration_s());
  }

  const Drive& drive_;
  const SimulationOptions& options_;
  const SimulationSink& sink_;
  SurfaceIndex surfaces_;
  Crowd crowd_;
  FaultyMotion motion_;
  Rng drops_;
  WheelSensor wheels_;
  ImuSensor imu_;
  LaserSensor laser_;
  std::optional<LaserRealism> laser_realism_{};
  MessageLoss loss_;
  StampErrors wheel_stamps_{};
  StampErrors imu_stamps_{};
  StampErrors laser_stamps_{};
  std::optional<RgbdSensor> camera_{};
  Clock camera_clock_{1.0, 0.0};
  std::int64_t camera_index_ = 0;
  Clock wheel_clock_{1.0, 0.0};
  Clock imu_clock_{1.0, 0.0};
  Clock laser_clock_{1.0, 0.0};
  std::int64_t wheel_index_ = 0;
  std::int64_t imu_index_ = 0;
  std::int64_t laser_index_ = 0;
  double wheel_time_ = 0.0;
  double wheel_stamp_ = 0.0;
  double previous_stamp_ = 0.0;
  double imu_stamp_ = 0.0;
  double laser_stamp_ = 0.0;
  std::array<std::int64_t, 4> counts_{};
  Pose2 odom_T_previous_{};
  SimulationSummary summary_{};
};

}  // namespace

SimulationSummary simulate_drive(const World& world, const Drive& drive, const RobotModel& robot,
                                 const SimulationOptions& options, std::uint64_t seed,
                                 const SimulationSink& sink) {
  require_valid(options);
  const double sweep_s =
      options.realism.sweep.on ? options.realism.sweep.sweep_s : options.laser.sweep_s;
  if (sweep_s > 1.0 / options.laser.rate_hz) {
    throw UsageError("a sweep of " + std::to_string(sweep_s) + " s does not fit between scans at " +
                     std::to_string(options.laser.rate_hz) + " Hz");
  }
  return Simulator(world, drive, robot, options, seed, sink).run();
}

SimulationSummary simulate(const World& world, const RobotModel& robot,
                           const SimulationOptions& options, std::uint64_t seed,
                           const SimulationSink& sink) {
  Drive drive =
      planned_drive(world, robot.footprint_radius_m, options.drive, options.realism, seed);
  if (options.duration_s > 0.0) drive.cut(options.duration_s);
  return simulate_drive(world, drive, robot, options, seed, sink);
}

}  // namespace loopstone
