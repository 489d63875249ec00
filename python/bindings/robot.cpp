#include "robot.hpp"

#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "loopstone/formats/robot_file.hpp"
#include "methods.hpp"
#include "path_like.hpp"

namespace loopstone::python {

namespace {

bool is_same(const LidarMount& a, const LidarMount& b) {
  return a.name == b.name && a.robot_T_lidar == b.robot_T_lidar && a.height_m == b.height_m &&
         a.upside_down == b.upside_down && a.sweep_s == b.sweep_s;
}

void bind_lidar(nb::module_& m) {
  const LidarMount usual;
  nb::class_<LidarMount> lidar(m, "LidarMount",
                               "Where a planar lidar sits on the robot; can't be changed.");
  lidar.def(
      "__init__",
      [](LidarMount* self, double x_m, double y_m, double yaw_rad, double height_m,
         bool upside_down, double sweep_s, const std::string& name) {
        new (self) LidarMount{name, {x_m, y_m, yaw_rad}, height_m, upside_down, sweep_s};
      },
      nb::arg("x_m") = usual.robot_T_lidar.x, nb::arg("y_m") = usual.robot_T_lidar.y,
      nb::arg("yaw_rad") = usual.robot_T_lidar.yaw, nb::kw_only(),
      nb::arg("height_m") = usual.height_m, nb::arg("upside_down") = usual.upside_down,
      nb::arg("sweep_s") = usual.sweep_s, nb::arg("name") = usual.name,
      "By default that of the UCSD robot. Values are checked by the robot that gets it.");
  lidar.def_prop_ro(
      "x_m", [](const LidarMount& l) { return l.robot_T_lidar.x; },
      "Ahead of the robot's centre [m].");
  lidar.def_prop_ro(
      "y_m", [](const LidarMount& l) { return l.robot_T_lidar.y; }, "Left of it [m].");
  lidar.def_prop_ro(
      "yaw_rad", [](const LidarMount& l) { return l.robot_T_lidar.yaw; },
      "Where its x axis points, counter-clockwise [rad].");
  def_array(
      lidar, "robot_T_lidar", [](const LidarMount& l) { return to_array(l.robot_T_lidar); },
      "(3,) the three together.");
  lidar.def_ro("height_m", &LidarMount::height_m, "Above the floor [m].");
  lidar.def_ro("upside_down", &LidarMount::upside_down,
               "Its beams go round the other way than its scans say.");
  lidar.def_ro(
      "sweep_s", &LidarMount::sweep_s,
      "From the first beam to the last, where scans do not tell; negative: the last comes\n"
      "first [s].");
  lidar.def_ro("name", &LidarMount::name, "For people.");
  def_python(lidar, "replace", "loopstone._values", "replaced_lidar",
             "def replace(self, **changes: typing.Any) -> LidarMount",
             "The same with other values of some: ``lidar.replace(x_m=0.2)``.");
  lidar.def(
      "__eq__",
      [](const LidarMount& self, nb::handle other) {
        return nb::isinstance<LidarMount>(other) &&
               is_same(self, nb::cast<const LidarMount&>(other));
      },
      nb::arg("other").none(), nb::sig("def __eq__(self, other: object, /) -> bool"));
  lidar.def("__repr__", [](const LidarMount& l) {
    const Pose2& at = l.robot_T_lidar;
    return fmt::format("<LidarMount '{}' at ({:.3f}, {:.3f}) m, {:.4f} rad>", l.name, at.x, at.y,
                       at.yaw);
  });
}

void bind_wheels(nb::module_& m) {
  nb::class_<WheelModel> wheels(m, "WheelModel",
                                "A differential drive, of :attr:`Robot.wheels`; can't be changed.");
  wheels.def_ro("metres_per_count", &WheelModel::metres_per_count,
                "How far a wheel rolls for each encoder count.");
  wheels.def_ro("track_width_m", &WheelModel::track_width_m,
                "Effective distance of the left from the right wheels, for turning.");
  wheels.def_ro("counts_are_cumulative", &WheelModel::counts_are_cumulative,
                "Since the start; else since the last reading.");
  wheels.def_ro("counter_bits", &WheelModel::counter_bits,
                "Cumulative counters wrap at 2 to this power.");
  wheels.def_ro("radius_m", &WheelModel::radius_m, "Of wheels that are told as angles.");
  wheels.def("__repr__", [](const WheelModel& w) {
    return fmt::format("<WheelModel: {:.6g} m a count, track {:.4g} m>", w.metres_per_count,
                       w.track_width_m);
  });
}

Robot with_values(const Robot& self, const RobotValues& changes,
                  const std::optional<std::vector<LidarMount>>& lidars) {
  Robot robot = self;
  if (lidars) robot.model.lidars = *lidars;
  robot.model = changed_robot(std::move(robot.model), changes, "robot");
  robot.stated = changed_stated_wheels(robot.stated, robot.model.wheels, changes);
  return robot;
}

void def_parts(nb::class_<Robot>& robot) {
  robot.def_prop_ro(
      "name", [](const Robot& self) { return self.model.name; }, "What its file calls it.");
  robot.def_prop_ro(
      "footprint_radius_m", [](const Robot& self) { return self.model.footprint_radius_m; },
      "Cells this near to its path are free.");
  robot.def_prop_ro(
      "odometry_scale", [](const Robot& self) { return self.model.odometry_scale; },
      "Odometry's way / the real one; 1: learned while driving.");
  robot.def_prop_ro(
      "wheels", [](const Robot& self) { return self.model.wheels; }, "What its counts mean.");
  robot.def_prop_ro(
      "lidars", [](const Robot& self) { return self.model.lidars; },
      "Where each sits; a copy: replace() changes it.");
  def_array(
      robot, "robot_T_lidars",
      [](const Robot& self) {
        std::vector<Pose2> mounts;
        for (const LidarMount& lidar : self.model.lidars) mounts.push_back(lidar.robot_T_lidar);
        return to_array(std::span<const Pose2>(mounts));
      },
      "(L, 3) x, y [m], yaw [rad] of each lidar on the robot.");
}

}  // namespace

void bind_robot(nb::module_& m) {
  bind_lidar(m);
  bind_wheels(m);
  nb::class_<Robot> robot(
      m, "Robot",
      "What is fixed about a robot: wheels, and where its sensors sit. The defaults are those of\n"
      "the UCSD robot, ``robots/ucsd.toml``; a log's own words beat them. Can't be changed;\n"
      "replace() makes another one.");
  robot.def(
      "__init__",
      [](Robot* self, const std::string& toml) {
        new (self) Robot{parse_robot(toml, "toml"), stated_wheels(toml, "toml")};
      },
      nb::arg("toml") = "",
      "From the text of a robot file. Raises OptionsError with all that is wrong with it.");
  robot.def_static(
      "read",
      [](const PathLike& path) {
        return Robot{read_robot_file(path.value), read_stated_wheels(path.value)};
      },
      nb::arg("path"), "From a robot file. Raises OptionsError, DataError.");
  robot.def(
      "to_toml", [](const Robot& self) { return robot_to_toml(self.model); },
      "As the text of a robot file, with help texts.");
  def_parts(robot);
  def_python(
      robot, "replace", "loopstone._values", "replaced_robot",
      "def replace(self, changes: collections.abc.Mapping[str, typing.Any] | None = None, /, "
      "*, lidars: collections.abc.Sequence[LidarMount] | None = None, **values: typing.Any) "
      "-> Robot",
      "The same robot with other values of some keys of a robot file, two underscores for\n"
      "the dot: ``robot.replace(wheels__track_width_m=0.4, footprint_radius_m=0.3)``.\n\n"
      ":param changes: the same by their dotted keys: ``{\"lidars[0].x_m\": 0.2}``\n"
      ":param lidars: in place of all that it has\n"
      ":raises OptionsError: with all that is wrong with them");
  robot.def("__repr__", [](const Robot& self) { return "<Robot '" + self.model.name + "'>"; });
  m.def("replaced_robot", with_values, nb::arg("robot"), nb::arg("changes"),
        nb::arg("lidars").none());
}

}  // namespace loopstone::python
