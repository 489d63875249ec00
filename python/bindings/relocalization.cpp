#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "known_map.hpp"
#include "loopstone/localization/relocalize.hpp"
#include "robot.hpp"
#include "work.hpp"

namespace loopstone::python {

namespace {

/// \param odom_T_robot  (N, 3) of the robot at each scan; absent: all were taken at one place
std::vector<TakenScan> taken_scans(const std::vector<LaserScan>& scans, const Robot* robot,
                                   const std::optional<ArrayLike>& odom_T_robot,
                                   const std::optional<ArrayLike>& velocity) {
  std::vector<Pose2> poses(scans.size());
  if (odom_T_robot) poses = poses_of(*odom_T_robot, "odom_T_robot");
  if (poses.size() != scans.size())
    throw nb::value_error("odom_T_robot: there must be as many poses as scans");
  Tangent2 speed = Tangent2::Zero();
  if (velocity) {
    const Numbers given = numbers_of(*velocity, "velocity");
    if (given.shape != std::vector<std::size_t>{3})
      throw nb::value_error("velocity: expected an array of shape (3,)");
    speed = Tangent2(given.values[0], given.values[1], given.values[2]);
  }
  const RobotModel model = robot == nullptr ? RobotModel{} : robot->model;
  std::vector<TakenScan> taken;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    taken.push_back({.scan = scans[i],
                     .robot_T_lidar = mount_of(scans[i], model),
                     .robot_T_then = poses.back().inverse() * poses[i],
                     .velocity = speed});
  }
  return taken;
}

void bind_candidate(nb::module_& m) {
  nb::class_<PlaceCandidate> candidate(m, "PlaceCandidate",
                                       "A pose that scans may have been taken from.");
  def_array(
      candidate, "map_T_robot", [](const PlaceCandidate& c) { return to_array(c.map_T_robot); },
      "(3,) x, y [m], yaw [rad].");
  def_array(
      candidate, "covariance",
      [](const PlaceCandidate& c) { return to_array(Eigen::MatrixXd(c.covariance)); },
      "(3, 3) of map_T_robot, axes of the map [m^2, m rad, rad^2].");
  candidate.def_ro("probability", &PlaceCandidate::probability,
                   "That the robot is within 0.2 m and 5 deg of the pose.");
  const auto fit = [&candidate](const char* name, double BeamFit::*field, const char* doc) {
    candidate.def_prop_ro(
        name, [field](const PlaceCandidate& c) { return c.fit.*field; }, doc);
  };
  fit("explained", &BeamFit::explained,
      "[0, 1], of the returns where the map knows what is there, the share on a wall.");
  fit("violations", &BeamFit::violations,
      "[0, 1], share of the beams that went on behind a wall of the map.");
  fit("unexpected", &BeamFit::unexpected,
      "[0, 1], share of the beams that ended well before one: people, things that are new.");
  fit("known", &BeamFit::known, "[0, 1], share of the returns where the map knows what is there.");
  fit("silent", &BeamFit::silent,
      "[0, 1], share of the beams without a return where a wall is near.");
  candidate.def("__repr__", [](const PlaceCandidate& c) {
    return fmt::format("<PlaceCandidate ({:.2f}, {:.2f}) m, {:.1f} %>", c.map_T_robot.x,
                       c.map_T_robot.y, 100.0 * c.probability);
  });
}

}  // namespace

void bind_relocalization(nb::module_& m) {
  bind_candidate(m);
  nb::class_<Relocalization> found(m, "Relocalization",
                                   "Where on a map scans may have been taken; see\n"
                                   ":func:`loopstone.relocalize`.");
  found.def_ro("candidates", &Relocalization::candidates, "The most probable first; may be none.");
  def_array(
      found, "poses",
      [](const Relocalization& self) {
        std::vector<Pose2> poses;
        for (const PlaceCandidate& c : self.candidates) poses.push_back(c.map_T_robot);
        return to_array(std::span<const Pose2>(poses));
      },
      "(C, 3) map_T_robot of the candidates.");
  def_array(
      found, "probabilities",
      [](const Relocalization& self) {
        std::vector<double> values;
        for (const PlaceCandidate& c : self.candidates) values.push_back(c.probability);
        const std::size_t count = values.size();
        return array_of<double, nb::ndim<1>>(std::move(values), {count});
      },
      "(C,) of the candidates.");
  found.def_ro("none_probability", &Relocalization::none_probability,
               "That the robot is at none of these places: elsewhere on the map, or not on it.");
  found.def_ro("complete", &Relocalization::complete,
               "False: more places look alike than were looked into.");
  found.def("__len__", [](const Relocalization& self) { return self.candidates.size(); });
  found.def("__repr__", [](const Relocalization& self) {
    if (self.candidates.empty()) return std::string("<Relocalization: no candidate>");
    return fmt::format("<Relocalization: {} candidates, the best {:.1f} %, none of them {:.1f} %>",
                       self.candidates.size(), 100.0 * self.candidates.front().probability,
                       100.0 * self.none_probability);
  });
  m.def(
      "relocalize",
      [](const std::vector<LaserScan>& scans, const KnownMap& map, const Robot* robot,
         const std::optional<ArrayLike>& odom_T_robot, const std::optional<ArrayLike>& velocity,
         int threads) {
        const auto taken = taken_scans(scans, robot, odom_T_robot, velocity);
        // Well under a second: there is no place to stop at.
        return work(nb::none(), [&](Work& /*own*/) {
          return loopstone::relocalize(*map.map, std::span<const TakenScan>(taken),
                                       Threads{threads});
        });
      },
      nb::arg("scans"), nb::arg("map"), nb::arg("robot").none(), nb::arg("odom_T_robot").none(),
      nb::arg("velocity").none(), nb::arg("threads"));
}

}  // namespace loopstone::python
