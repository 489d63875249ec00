#include "messages.hpp"

#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "loopstone/sensor/robot_model.hpp"
#include "loopstone/sensor/scan_points.hpp"
#include "robot.hpp"
#include "stamps.hpp"

namespace loopstone::python {

namespace {

void require_finite(double value, const char* name) {
  if (std::isfinite(value)) return;
  throw nb::value_error((std::string(name) + ": must be finite").c_str());
}

void require_beams(const LaserScan& scan) {
  if (scan.ranges_m.empty()) throw nb::value_error("ranges_m: a scan has at least one beam");
  require_finite(scan.angle_min_rad, "angle_min_rad");
  require_finite(scan.angle_increment_rad, "angle_increment_rad");
  require_finite(scan.range_min_m, "range_min_m");
  require_finite(scan.range_max_m, "range_max_m");
  require_finite(scan.time_increment_s, "time_increment_s");
  if (!scan.intensities.empty() && scan.intensities.size() != scan.ranges_m.size())
    throw nb::value_error("intensities: there must be one for each range");
  if (scan.lidar < 0) throw nb::value_error("lidar: must be 0 or more");
}

LaserScan make_scan(std::int64_t stamp_ns, const ArrayLike& ranges_m, double angle_min_rad,
                    double angle_increment_rad, double range_min_m, double range_max_m,
                    double time_increment_s, int lidar,
                    const std::optional<ArrayLike>& robot_T_lidar,
                    const std::optional<ArrayLike>& intensities) {
  LaserScan scan{.stamp = {stamp_ns},
                 .angle_min_rad = angle_min_rad,
                 .angle_increment_rad = angle_increment_rad,
                 .range_min_m = range_min_m,
                 .range_max_m = range_max_m,
                 .time_increment_s = time_increment_s,
                 .lidar = lidar};
  if (robot_T_lidar) scan.robot_T_lidar = pose_of(*robot_T_lidar, "robot_T_lidar");
  scan.ranges_m = floats_of(ranges_m, "ranges_m");
  if (intensities) scan.intensities = floats_of(*intensities, "intensities");
  require_beams(scan);
  return scan;
}

Array<double, nb::ndim<1>> angles(const LaserScan& scan) {
  std::vector<double> values(scan.ranges_m.size());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = scan.angle_rad(i);
  const std::size_t count = values.size();
  return array_of<double, nb::ndim<1>>(std::move(values), {count});
}

Matrix points(const LaserScan& scan, const Robot* robot, const std::optional<ArrayLike>& velocity) {
  Tangent2 speed = Tangent2::Zero();
  if (velocity) {
    const Numbers numbers = numbers_of(*velocity, "velocity");
    if (numbers.shape != std::vector<std::size_t>{3})
      throw nb::value_error("velocity: expected an array of shape (3,): m/s, m/s, rad/s");
    speed = Eigen::Map<const Eigen::Vector3d>(numbers.values.data());
  }
  const RobotModel model = robot == nullptr ? RobotModel{} : robot->model;
  const auto found = scan_points(scan, mount_of(scan, model), speed);
  std::vector<double> values;
  values.reserve(2 * found.size());
  for (const Eigen::Vector2d& p : found) values.insert(values.end(), {p.x(), p.y()});
  return array_of<double, nb::ndim<2>>(std::move(values), {found.size(), 2});
}

void def_arrays(nb::class_<LaserScan>& scan) {
  def_array(
      scan, "robot_T_lidar",
      [](const LaserScan& self) -> std::optional<Vector> {
        if (!self.robot_T_lidar) return {};
        return to_array(*self.robot_T_lidar);
      },
      "(3,) x, y, yaw of the lidar on the robot, where the log states it.");
  scan.def_prop_ro(
      "ranges_m",
      [](nb::handle_t<LaserScan> self) {
        return view_of(std::span<const float>(nb::cast<const LaserScan&>(self).ranges_m), self);
      },
      "(N,) float32 [m]: a read-only view, no copy.");
  scan.def_prop_ro(
      "intensities",
      [](nb::handle_t<LaserScan> self) {
        return view_of(std::span<const float>(nb::cast<const LaserScan&>(self).intensities), self);
      },
      "(N,) float32 in the scanner's unit, a read-only view; (0,) when there are none.");
  def_array(scan, "angles_rad", angles, "(N,) float64: where each beam points, lidar frame [rad].");
  scan.def("points", points, nb::kw_only(), nb::arg("robot") = nb::none(),
           nb::arg("velocity") = nb::none(),
           "(M, 2) returns in the robot's frame [m], in the order of the beams.\n\n"
           ":param robot: where the lidar sits, unless the scan itself says so\n"
           ":param velocity: (3,) of the robot in its own frame [m/s, m/s, rad/s]; undoes the\n"
           "    motion during the sweep");
}

void bind_scan(nb::module_& m) {
  nb::class_<LaserScan> scan(
      m, "LaserScan",
      "One sweep of a planar laser scanner; it can't be changed.\n\n"
      "Beam i points to ``angle_min_rad + i * angle_increment_rad``, counter-clockwise from the\n"
      "lidar's x axis. A finite range within the limits is a return, +inf means nothing within\n"
      "range, NaN a bad beam (REP-117).");
  scan.def(
      "__init__",
      [](LaserScan* self, std::int64_t stamp_ns, const ArrayLike& ranges_m, double angle_min_rad,
         double angle_increment_rad, double range_min_m, double range_max_m,
         double time_increment_s, int lidar, const std::optional<ArrayLike>& robot_T_lidar,
         const std::optional<ArrayLike>& intensities) {
        new (self)
            LaserScan(make_scan(stamp_ns, ranges_m, angle_min_rad, angle_increment_rad, range_min_m,
                                range_max_m, time_increment_s, lidar, robot_T_lidar, intensities));
      },
      nb::arg("stamp_ns"), nb::arg("ranges_m"), nb::kw_only(), nb::arg("angle_min_rad"),
      nb::arg("angle_increment_rad"), nb::arg("range_min_m") = 0.0, nb::arg("range_max_m"),
      nb::arg("time_increment_s") = 0.0, nb::arg("lidar") = 0,
      nb::arg("robot_T_lidar") = nb::none(), nb::arg("intensities") = nb::none(),
      "A scan of numbers that are copied. Raises ValueError for what is no scan.\n\n"
      ":param ranges_m: (N,) metres, which are kept as float32");
  def_stamp(scan);
  scan.def_ro("angle_min_rad", &LaserScan::angle_min_rad, "Of beam 0 [rad].");
  scan.def_ro("angle_increment_rad", &LaserScan::angle_increment_rad,
              "From beam to beam [rad]; negative for clockwise scanners.");
  scan.def_ro("range_min_m", &LaserScan::range_min_m, "Nearer returns do not count [m].");
  scan.def_ro("range_max_m", &LaserScan::range_max_m, "Nor do farther ones [m].");
  scan.def_ro("time_increment_s", &LaserScan::time_increment_s,
              "Between neighbouring beams [s]; 0: unknown, or all at once.");
  scan.def_ro("lidar", &LaserScan::lidar, "Which of the robot's lidars.");
  def_arrays(scan);
  scan.def("__len__", [](const LaserScan& self) { return self.ranges_m.size(); });
  scan.def("__repr__", [](const LaserScan& self) {
    return fmt::format("<LaserScan at {:.6f} s, {} beams>", self.stamp.seconds(),
                       self.ranges_m.size());
  });
}

void bind_odometry(nb::module_& m) {
  nb::class_<OdometryPose> pose(m, "OdometryPose",
                                "A pose that the robot's own dead reckoning reported.");
  pose.def(
      "__init__",
      [](OdometryPose* self, std::int64_t stamp_ns, const ArrayLike& odom_T_robot) {
        new (self) OdometryPose{{stamp_ns}, pose_of(odom_T_robot, "odom_T_robot")};
      },
      nb::arg("stamp_ns"), nb::arg("odom_T_robot"),
      "Of (3,) x, y [m], yaw [rad]. Raises ValueError.");
  def_stamp(pose);
  def_array(
      pose, "odom_T_robot", [](const OdometryPose& self) { return to_array(self.odom_T_robot); },
      "(3,) x, y [m], yaw [rad] in the odometry's frame.");

  nb::class_<WheelTicks> ticks(m, "WheelTicks", "Encoder counts of the wheels.");
  ticks.def(
      "__init__",
      [](WheelTicks* self, std::int64_t stamp_ns, const std::array<std::int64_t, 4>& counts) {
        new (self) WheelTicks{{stamp_ns}, counts};
      },
      nb::arg("stamp_ns"), nb::arg("counts"), "Of four whole numbers, in the order of ``counts``.");
  def_stamp(ticks);
  ticks.def_prop_ro(
      "counts",
      [](const WheelTicks& self) {
        const auto& c = self.counts;
        return nb::make_tuple(c[0], c[1], c[2], c[3]);
      },
      nb::sig("def counts(self) -> tuple[int, int, int, int]"),
      "(front right, front left, rear right, rear left), since the reading before or absolute, "
      "as the robot says.");

  nb::class_<ImuSample> imu(m, "ImuSample",
                            "A reading of an inertial unit, on the axes of the robot.");
  imu.def(
      "__init__",
      [](ImuSample* self, std::int64_t stamp_ns, const ArrayLike& angular_velocity_rad_s,
         const ArrayLike& linear_acceleration_m_s2) {
        const auto vector = [](const ArrayLike& given, const char* name) -> Eigen::Vector3d {
          const Numbers numbers = numbers_of(given, name);
          if (numbers.shape != std::vector<std::size_t>{3})
            throw nb::value_error(
                (std::string(name) + ": expected an array of shape (3,)").c_str());
          return Eigen::Map<const Eigen::Vector3d>(numbers.values.data());
        };
        new (self) ImuSample{{stamp_ns},
                             vector(angular_velocity_rad_s, "angular_velocity_rad_s"),
                             vector(linear_acceleration_m_s2, "linear_acceleration_m_s2")};
      },
      nb::arg("stamp_ns"), nb::arg("angular_velocity_rad_s"), nb::arg("linear_acceleration_m_s2"),
      "Of (3,) rad/s and (3,) m/s^2. Raises ValueError.");
  def_stamp(imu);
  def_array(
      imu, "angular_velocity_rad_s",
      [](const ImuSample& self) { return to_array(self.angular_velocity_rad_s); },
      "(3,) about the axes of the robot [rad/s].");
  def_array(
      imu, "linear_acceleration_m_s2",
      [](const ImuSample& self) { return to_array(self.linear_acceleration_m_s2); },
      "(3,) along the axes of the robot [m/s^2].");
}

void bind_frame(nb::module_& m) {
  nb::class_<RgbdFrame> frame(
      m, "RgbdFrame", "Which pictures an RGB-D camera took, and where they are; no pixels.");
  def_stamp(frame);
  frame.def_prop_ro(
      "colour_stamp_ns", [](const RgbdFrame& self) { return self.colour_stamp.nanoseconds; },
      "Of the colour picture; the two need not be taken at once.");
  frame.def_ro("colour_path", &RgbdFrame::colour_path,
               "A file, or the topic of a recording; empty: there is only depth.");
  frame.def_ro("depth_path", &RgbdFrame::depth_path, "Likewise; empty: there is only colour.");
}

template <typename Message>
bool take(nb::handle object, std::optional<SensorMessage>& taken) {
  if (!nb::isinstance<Message>(object)) return false;
  taken = nb::cast<const Message&>(object);
  return true;
}

}  // namespace

SensorMessage message_of(nb::handle object) {
  std::optional<SensorMessage> taken;
  if (take<LaserScan>(object, taken) || take<OdometryPose>(object, taken) ||
      take<WheelTicks>(object, taken) || take<ImuSample>(object, taken) ||
      take<RgbdFrame>(object, taken)) {
    return std::move(*taken);
  }
  throw nb::type_error(
      ("expected a message (LaserScan, OdometryPose, WheelTicks, ImuSample, RgbdFrame), not " +
       nb::cast<std::string>(nb::handle(object.type()).attr("__name__")))
          .c_str());
}

nb::object to_object(SensorMessage message) {
  return std::visit([](auto& m) { return nb::cast(std::move(m)); }, message);
}

void bind_messages(nb::module_& m) {
  bind_scan(m);
  bind_odometry(m);
  bind_frame(m);
}

}  // namespace loopstone::python
