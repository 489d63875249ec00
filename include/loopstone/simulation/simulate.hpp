#pragma once

#include <cstdint>
#include <functional>

#include "loopstone/base/options.hpp"
#include "loopstone/odometry/trajectory.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/rgbd_images.hpp"
#include "loopstone/sensor/robot_model.hpp"
#include "loopstone/simulation/drive.hpp"
#include "loopstone/simulation/realism.hpp"
#include "loopstone/simulation/simulated_camera.hpp"
#include "loopstone/simulation/simulated_faults.hpp"
#include "loopstone/simulation/world.hpp"

namespace loopstone {

/// A planar laser scanner. The defaults are the UCSD robot's Hokuyo UTM-30LX, but for the rate: it
/// sweeps 40 times a second, of which every fourth is kept so that logs stay small.
struct SimulatedLaser {
  double rate_hz = 10.0;
  int beams = 1081;
  double fov_rad = 1.5 * kPi;
  double range_min_m = 0.1;
  double range_max_m = 30.0;
  double noise_m = 0.01;
  double dropout_probability = 0.002;
  double sweep_s = 0.01875;
  double clock_offset_s = 0.005;
};

/// Wheel encoders, and how wheels differ from their model. Systematic errors are drawn once for
/// each seed: between half and all of the given size, either sign.
struct SimulatedWheels {
  double rate_hz = 40.0;
  double scale_error = 0.02;
  double imbalance = 0.0003;
  double turn_slip = 0.01;
  double slip_m_per_sqrt_m = 0.003;
};

/// Gyro and accelerometer.
struct SimulatedImu {
  double rate_hz = 100.0;
  double bias_rad_s = 0.01;
  double bias_drift_rad_s = 0.0002;
  double noise_rad_s = 0.004;
  double acceleration_noise_m_s2 = 0.05;
};

struct SimulationOptions {
  double duration_s = 0.0;
  double start_s = 1000.0;
  int people = 0;
  bool odometry_poses = false;
  DriveOptions drive{};
  SimulatedLaser laser{};
  SimulatedWheels wheels{};
  SimulatedImu imu{};
  SimulatedCamera camera{};
  SimulatedFaults faults{};
  Realism realism{};
};

template <typename Visitor>
void visit_options(DriveOptions& options, Visitor&& visit) {
  visit("speed_m_s", options.speed_m_s, Range{0.1, 2.0}, "top speed");
  visit("yaw_rate_rad_s", options.yaw_rate_rad_s, Range{0.2, 3.0}, "fastest turn");
  visit("acceleration_m_s2", options.acceleration_m_s2, Range{0.1, 5.0}, "how fast it gains speed");
  visit("standstill_s", options.standstill_s, Range{0.0, 60.0}, "rest before it sets off");
  visit("laps", options.laps, Range{1, 1000},
        "times that it goes the whole route, each time back to the start");
}

template <typename Visitor>
void visit_options(SimulatedLaser& options, Visitor&& visit) {
  visit("rate_hz", options.rate_hz, Range{0.1, 100.0}, "scans a second");
  visit("beams", options.beams, Range{2, 20000}, "beams of a scan");
  visit("fov_rad", options.fov_rad, Range{0.01, 6.2832},
        "from the first beam to the last, centred on the lidar's x axis");
  visit("range_min_m", options.range_min_m, Range{0.0, 5.0}, "nearer returns are bad beams");
  visit("range_max_m", options.range_max_m, Range{0.5, 500.0}, "farther surfaces give no return");
  visit("noise_m", options.noise_m, Range{0.0, 1.0}, "standard deviation of a range");
  visit("dropout_probability", options.dropout_probability, Range{0.0, 1.0}, "share of bad beams");
  visit("sweep_s", options.sweep_s, Range{0.0, 1.0}, "time from the first beam to the last");
  visit("clock_offset_s", options.clock_offset_s, Range{-1.0, 1.0},
        "the laser's stamps are this late");
}

template <typename Visitor>
void visit_options(SimulatedWheels& options, Visitor&& visit) {
  visit("rate_hz", options.rate_hz, Range{1.0, 1000.0}, "readings a second");
  visit("scale_error", options.scale_error, Range{0.0, 0.5},
        "both sides too large or too small, share of the distance");
  visit("imbalance", options.imbalance, Range{0.0, 0.2},
        "one side against the other, share of the distance");
  visit("turn_slip", options.turn_slip, Range{0.0, 0.5}, "wheels turn more than the robot, share");
  visit("slip_m_per_sqrt_m", options.slip_m_per_sqrt_m, Range{0.0, 0.5},
        "random slip: standard deviation after 1 m of travel; grows with the root");
}

template <typename Visitor>
void visit_options(SimulatedImu& options, Visitor&& visit) {
  visit("rate_hz", options.rate_hz, Range{1.0, 2000.0}, "samples a second");
  visit("bias_rad_s", options.bias_rad_s, Range{0.0, 1.0},
        "bias of the gyro, drawn as the systematic errors of the wheels");
  visit("bias_drift_rad_s", options.bias_drift_rad_s, Range{0.0, 0.1},
        "random walk of the bias: standard deviation after a minute");
  visit("noise_rad_s", options.noise_rad_s, Range{0.0, 1.0}, "standard deviation of a gyro sample");
  visit("acceleration_noise_m_s2", options.acceleration_noise_m_s2, Range{0.0, 10.0},
        "standard deviation of an accelerometer sample");
}

template <typename Visitor>
void visit_options(SimulationOptions& options, Visitor&& visit) {
  visit("duration_s", options.duration_s, Range{0.0, 1e6}, "cuts the drive; 0: the whole route");
  visit("start_s", options.start_s, Range{0.0, 4e9}, "stamp of the first moment");
  visit("people", options.people, Range{0, 1000}, "people who walk about");
  visit("odometry_poses", options.odometry_poses,
        "the robot's own dead reckoning instead of counts and imu, as CARMEN logs it");
  visit.group("drive", options.drive);
  visit.group("laser", options.laser);
  visit.group("wheels", options.wheels);
  visit.group("imu", options.imu);
  visit.group("camera", options.camera);
  visit.group("faults", options.faults);
  visit.group("realism", options.realism);
}

/// The pictures of one frame of the RGB-D camera.
struct SimulatedFrame {
  std::int64_t index = 0;  ///< of the frame, from 0
  Stamp depth_stamp{};
  Stamp colour_stamp{};
  RawDepthImage depth{};
  ColourImage colour{};
};

/// Where a simulation's output goes. Called in the order of the stamps; each may be empty.
struct SimulationSink {
  std::function<void(SensorMessage)> message{};
  /// Keeps the pictures of a frame and returns the message that says where they are, which then
  /// goes to `message`. Without it nothing is rendered.
  std::function<RgbdFrame(const SimulatedFrame&)> frame{};
  /// map_T_robot at the first beam of every scan, with the scan's stamp.
  std::function<void(const StampedPose2&)> truth{};
  /// Told how much of the drive is done; returns false to stop.
  std::function<bool(double done_s, double total_s)> progress{};
};

/// What was simulated.
struct SimulationSummary {
  double duration_s = 0.0;
  double route_length_m = 0.0;
  std::int64_t scans = 0;
  std::int64_t frames = 0;  ///< of the RGB-D camera
  std::int64_t messages = 0;
  bool complete = true;     ///< false when progress asked to stop
  RealismRecord realism{};  ///< what was drawn, but for the world (real_world)
};

/// Drives the robot through the world and lets its sensors measure: WheelTicks and ImuSample (or
/// OdometryPose, one with each scan's stamp and one with each encoder reading's), LaserScan of the
/// robot's first lidar, and RgbdFrame of its camera when the sink takes frames. The same arguments
/// give the same messages to the bit, and those of the other sensors are the same with and without
/// the camera. Of `options.realism`, bent and turned are the caller's, who has the world: see
/// real_world. Truth is the robot's, at the true time of the scan, with the stamp that the log has.
/// Memory: the drive (about 3 kB a second) and the world.
/// Cost: about 0.3 us a beam, 50 ms an RGB-D frame.
SimulationSummary simulate(const World& world, const RobotModel& robot,
                           const SimulationOptions& options, std::uint64_t seed,
                           const SimulationSink& sink);

/// The same over a given drive, which nothing lifts and which begins where it begins.
SimulationSummary simulate_drive(const World& world, const Drive& drive, const RobotModel& robot,
                                 const SimulationOptions& options, std::uint64_t seed,
                                 const SimulationSink& sink);

}  // namespace loopstone
