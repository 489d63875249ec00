#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <string>
#include <utility>

#include "arrays.hpp"
#include "bindings.hpp"
#include "loopstone/pipeline/log_calibration.hpp"
#include "mapping.hpp"
#include "options.hpp"
#include "work.hpp"

namespace loopstone::python {

namespace {

/// What a log tells of its robot.
struct Calibrated {
  Calibration found{};
  std::optional<WheelFindings> wheels{};
  Robot given{};
  Robot corrected{};
  bool mount_is_certain = false;
  std::vector<std::string> warnings{};
};

std::shared_ptr<Calibrated> calibrate_log(const Log& log, const MapOptions& options,
                                          const LogCut& cut, Threads threads, Work& work) {
  const ReadingWatch watch = watch_by(work);
  const LogSource source = log.source(watch.stop);
  const auto reader = source.open();
  // As `loopstone calibrate` takes it: given wheels are what is to be judged.
  const RobotModel told = log.robot ? log.robot->model : reader->robot(RobotModel{});
  RobotFindings findings =
      loopstone::calibrate_log(source, *reader, told, cut, options, threads, watch);
  if (!work.goes_on()) throw CalledOff{};
  require_findings(findings, log.path);
  auto done = std::make_shared<Calibrated>();
  done->found = findings.map.calibration;
  done->mount_is_certain = findings.mount_is_certain();
  done->given.model = std::move(findings.given);
  done->corrected.model = std::move(findings.corrected);
  done->wheels = std::move(findings.wheels);
  done->warnings = warnings_of(findings.log);
  return done;
}

void bind_value(nb::module_& m) {
  nb::class_<CalibratedValue> value(m, "CalibratedValue", "A value that a log tells.");
  value.def_ro("value", &CalibratedValue::value, "Means nothing when it is not observable.");
  value.def_ro("sigma", &CalibratedValue::sigma, "One standard deviation.");
  value.def_ro("given", &CalibratedValue::given, "As the robot or the log has it.");
  value.def_ro("observable", &CalibratedValue::observable,
               "The robot moved so that the log tells it.");
  value.def("__repr__", [](const CalibratedValue& v) {
    if (!v.observable)
      return fmt::format("<CalibratedValue: not observable, given {:.6g}>", v.given);
    return fmt::format("<CalibratedValue {:.6g} +- {:.2g}, given {:.6g}>", v.value, v.sigma,
                       v.given);
  });
}

void bind_wheels(nb::module_& m) {
  nb::class_<WheelFindings> wheels(m, "WheelCalibration",
                                   "What wheel counts by themselves, without a gyro, tell.");
  wheels.def_prop_ro(
      "translation_scale", [](const WheelFindings& w) { return w.found.translation_scale; },
      "The way by the wheels / the laser's.");
  wheels.def_prop_ro(
      "rotation_scale", [](const WheelFindings& w) { return w.found.rotation_scale; },
      "The turns by the wheels / the laser's.");
  wheels.def_prop_ro(
      "turn_per_m_rad", [](const WheelFindings& w) { return w.found.turn_per_m_rad; },
      "They turn so far a metre while the robot does not.");
  wheels.def_prop_ro(
      "metres_per_count", [](const WheelFindings& w) { return w.wheels.metres_per_count; },
      "Put right, if it is certainly wrong; else as given.");
  wheels.def_prop_ro(
      "track_width_m", [](const WheelFindings& w) { return w.wheels.track_width_m; }, "Likewise.");
}

using Value = CalibratedValue Calibration::*;

void def_value(nb::class_<Calibrated>& cls, const char* name, Value value, const char* doc) {
  cls.def_prop_ro(
      name, [value](const Calibrated& self) { return self.found.*value; }, doc);
}

void def_values(nb::class_<Calibrated>& cls) {
  def_value(cls, "lidar_x_m", &Calibration::lidar_x_m, "Of the laser on the robot: ahead [m].");
  def_value(cls, "lidar_y_m", &Calibration::lidar_y_m, "To the left [m].");
  def_value(cls, "lidar_yaw_rad", &Calibration::lidar_yaw_rad, "Where it looks [rad].");
  def_value(cls, "translation_scale", &Calibration::translation_scale,
            "Odometry's way / the laser's.");
  def_value(cls, "rotation_scale", &Calibration::rotation_scale, "Odometry's turns / the laser's.");
  def_value(cls, "turn_bias_rad_s", &Calibration::turn_bias_rad_s,
            "Odometry turns so fast while the robot does not.");
  def_value(cls, "turn_per_m_rad", &Calibration::turn_per_m_rad,
            "Odometry turns so far a metre while the robot does not.");
  def_value(cls, "laser_delay_s", &Calibration::laser_delay_s,
            "Scans show the robot so long after their stamp, by odometry's clock.");
  def_value(cls, "sweep_s", &Calibration::sweep_s,
            "From the first beam to the last, where scans do not tell.");
}

void def_flag(nb::class_<Calibrated>& cls, const char* name, bool Calibration::*flag,
              const char* doc) {
  cls.def_prop_ro(
      name, [flag](const Calibrated& self) { return self.found.*flag; }, doc);
}

void bind_result(nb::module_& m) {
  nb::class_<Calibrated> cls(m, "CalibrationResult",
                             "How a robot's sensors sit and count, by its own motion; see\n"
                             ":func:`loopstone.calibrate`.");
  def_values(cls);
  cls.def_prop_ro(
      "motions", [](const Calibrated& self) { return self.found.motions; }, "That were compared.");
  def_array(
      cls, "lidar_covariance",
      [](const Calibrated& self) { return to_array(Eigen::MatrixXd(self.found.lidar_covariance)); },
      "(3, 3) of the laser's x, y, yaw on the robot.");
  cls.def_prop_ro(
      "mount_is_off", [](const Calibrated& self) { return self.found.mount_is_off(); },
      "The laser sits elsewhere than was told: significant, and both halves of the log say so.");
  cls.def_ro("mount_is_certain", &Calibrated::mount_is_certain,
             "So much so that a map is made with the mount put right.");
  def_flag(cls, "laser_is_mirrored", &Calibration::laser_is_mirrored,
           "Its beams go round the other way: it hangs upside down.");
  def_flag(cls, "mirror_is_in_doubt", &Calibration::mirror_is_in_doubt,
           "Or it is odometry that turns the other way; no gyro tells.");
  def_flag(cls, "sweep_is_off", &Calibration::sweep_is_off, "The sweep must be told.");
  cls.def_ro("wheels", &Calibrated::wheels, "By the wheels alone; None of a log without counts.");
  cls.def_ro("robot", &Calibrated::corrected,
             "With what is certainly wrong put right, as ``loopstone calibrate -o`` writes it.");
  cls.def_ro("robot_given", &Calibrated::given, "As it was told; beams that are off put right.");
  cls.def_ro("warnings", &Calibrated::warnings, "Of the log, in plain words.");
  cls.def("__repr__", [](const Calibrated& self) {
    return fmt::format("<CalibrationResult of {} motions{}>", self.found.motions,
                       self.found.mount_is_off() ? ": the laser sits elsewhere" : "");
  });
}

}  // namespace

void bind_calibration(nb::module_& m) {
  bind_value(m);
  bind_wheels(m);
  bind_result(m);
  m.def(
      "calibrate_log",
      [](const Log& log, const OptionValues& values, double start_s, double duration_s,
         std::int64_t max_scans, int threads, const nb::object& progress) {
        const auto options = options_of<MapOptions>(values);
        const LogCut cut{start_s, duration_s, max_scans};
        return work(progress, [&](Work& own) {
          return calibrate_log(log, options, cut, Threads{threads}, own);
        });
      },
      nb::arg("log"), nb::arg("options"), nb::arg("start_s"), nb::arg("duration_s"),
      nb::arg("max_scans"), nb::arg("threads"), nb::arg("progress").none());
}

}  // namespace loopstone::python
