#include "robot.hpp"

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <string>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "loopstone/formats/robot_file.hpp"
#include "path_like.hpp"

namespace loopstone::python {

void bind_robot(nb::module_& m) {
  nb::class_<Robot> robot(
      m, "Robot",
      "What is fixed about a robot: wheels, and where its sensors sit. The defaults are those of\n"
      "the UCSD robot, ``robots/ucsd.toml``; a log's own words beat them.");
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
  robot.def_prop_ro(
      "name", [](const Robot& self) { return self.model.name; }, "What its file calls it.");
  robot.def_prop_ro(
      "footprint_radius_m", [](const Robot& self) { return self.model.footprint_radius_m; },
      "Cells this near to its path are free.");
  def_array(
      robot, "robot_T_lidars",
      [](const Robot& self) {
        std::vector<Pose2> mounts;
        for (const LidarMount& lidar : self.model.lidars) mounts.push_back(lidar.robot_T_lidar);
        return to_array(std::span<const Pose2>(mounts));
      },
      "(L, 3) x, y [m], yaw [rad] of each lidar on the robot.");
  robot.def("__repr__", [](const Robot& self) { return "<Robot '" + self.model.name + "'>"; });
}

}  // namespace loopstone::python
