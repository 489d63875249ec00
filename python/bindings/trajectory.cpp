#include "loopstone/odometry/trajectory.hpp"

#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include <cstddef>
#include <string>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "loopstone/formats/machine_memory.hpp"
#include "loopstone/formats/tum.hpp"
#include "methods.hpp"
#include "path_like.hpp"

namespace loopstone::python {

namespace {

// Views into an array of them step from one to the next.
static_assert(sizeof(StampedPose2) == 32 && offsetof(StampedPose2, stamp) == 0 &&
              offsetof(StampedPose2, pose) == 8 && sizeof(Stamp) == 8 && sizeof(Pose2) == 24);
constexpr std::int64_t kStep = 4;

Trajectory make_trajectory(const ArrayLike& stamps_ns, const ArrayLike& poses) {
  const Integers given = integers_of(stamps_ns, "stamps_ns");
  if (given.shape.size() != 1) throw nb::value_error("stamps_ns: expected an array of shape (N,)");
  const std::vector<std::int64_t>& stamps = given.values;
  const std::vector<Pose2> all = poses_of(poses, "poses");
  if (stamps.size() != all.size())
    throw nb::value_error("stamps_ns and poses: there must be as many of one as of the other");
  Trajectory trajectory;
  trajectory.reserve(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool is_later = trajectory.empty() || stamps[i] > trajectory.back().stamp.nanoseconds;
    if (!is_later) throw nb::value_error("stamps_ns: must increase from each to the next");
    (void)trajectory.append({stamps[i]}, all[i]);
  }
  return trajectory;
}

using Strided = nb::ndarray<nb::numpy, const double, nb::ro, nb::shape<-1, 3>>;

Strided poses_view(nb::handle_t<Trajectory> self) {
  const auto& poses = nb::cast<const Trajectory&>(self).poses();
  const double* first = poses.empty() ? nullptr : &poses.front().pose.x;
  const std::array<std::size_t, 2> shape{poses.size(), 3};
  const std::array<std::int64_t, 2> steps{kStep, 1};
  return Strided(first, 2, shape.data(), self, steps.data());
}

View<std::int64_t, nb::ndim<1>> stamps_view(nb::handle_t<Trajectory> self) {
  const auto& poses = nb::cast<const Trajectory&>(self).poses();
  const std::int64_t* first = poses.empty() ? nullptr : &poses.front().stamp.nanoseconds;
  const std::array<std::size_t, 1> shape{poses.size()};
  const std::array<std::int64_t, 1> steps{kStep};
  return View<std::int64_t, nb::ndim<1>>(first, 1, shape.data(), self, steps.data());
}

Vector seconds(const Trajectory& self) {
  std::vector<double> values;
  values.reserve(self.size());
  for (const StampedPose2& pose : self.poses()) values.push_back(pose.stamp.seconds());
  const std::size_t count = values.size();
  return array_of<double, nb::ndim<1>>(std::move(values), {count});
}

std::optional<Vector> pose_at(const Trajectory& self, std::int64_t stamp_ns) {
  const auto pose = self.at(Stamp{stamp_ns});
  if (!pose) return {};
  return to_array(*pose);
}

}  // namespace

void bind_trajectory(nb::module_& m) {
  nb::class_<Trajectory> trajectory(
      m, "Trajectory", "Poses of the robot, their stamps strictly increasing; can't be changed.");
  trajectory.def(
      "__init__",
      [](Trajectory* self, const ArrayLike& stamps_ns, const ArrayLike& poses) {
        new (self) Trajectory(make_trajectory(stamps_ns, poses));
      },
      nb::arg("stamps_ns"), nb::arg("poses"),
      "Copies (N,) nanoseconds and (N, 3) x, y [m], yaw [rad]. Raises ValueError for what is no\n"
      "trajectory.");
  def_array(trajectory, "stamps_ns", stamps_view, "(N,) int64 [ns], a read-only view.");
  def_array(trajectory, "t", seconds, "(N,) float64 [s]; holds some 0.2 us.");
  def_array(trajectory, "poses", poses_view,
            "(N, 3) x, y [m], yaw [rad] in (-pi, pi], a read-only view.");
  trajectory.def_prop_ro("path_length_m", &Trajectory::path_length_m,
                         "Sum of the distances from each position to the next.");
  trajectory.def("at", pose_at, nb::arg("stamp_ns"),
                 "(3,) the pose at a stamp, along the arc between its neighbours; None outside.");
  trajectory.def(
      "to_tum", [](const Trajectory& self) { return format_tum(self); },
      "The text of a TUM file, ``t x y z qx qy qz qw`` a line, as the program writes it.");
  trajectory.def(
      "save",
      [](const Trajectory& self, const PathLike& path) {
        const nb::gil_scoped_release unlocked;
        write_tum(path.value, self);
      },
      nb::arg("path"), "Writes a TUM file, whole or not at all. Raises DataError.");
  def_python(trajectory, "to_pandas", "loopstone._convert", "trajectory_to_pandas",
             "def to_pandas(self) -> pandas.DataFrame",
             "Columns x_m, y_m, yaw_rad, indexed by stamp_ns. Needs loopstone[pandas].");
  def_python(trajectory, "to_evo", "loopstone._convert", "trajectory_to_evo",
             "def to_evo(self) -> typing.Any",
             "An evo.core.trajectory.PoseTrajectory3D. Needs evo, which is GPL-3.");
  trajectory.def("__len__", &Trajectory::size);
  trajectory.def("__repr__", [](const Trajectory& self) {
    return fmt::format("<Trajectory of {} poses, {:.1f} m>", self.size(), self.path_length_m());
  });
  m.def(
      "read_trajectory",
      [](const PathLike& path) {
        const nb::gil_scoped_release unlocked;
        return read_tum(path.value, machine_memory_budget());
      },
      nb::arg("path"),
      "Reads a TUM file; z, roll and pitch are dropped. Raises DataError with the line.");
}

}  // namespace loopstone::python
