#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/operators.h>
#include <nanobind/stl/string.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/pose2.hpp"

namespace loopstone::python {

namespace {

Pose2 make_pose(double x, double y, double yaw) {
  if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(yaw))
    throw nb::value_error("x, y, yaw: must be finite numbers");
  return {x, y, wrap_angle(yaw)};
}

Pose2 pose_by_twist(const ArrayLike& twist) {
  const Numbers given = numbers_of(twist, "twist");
  if (given.shape != std::vector<std::size_t>{3})
    throw nb::value_error("twist: expected an array of shape (3,)");
  const Pose2 moved = loopstone::exp(Tangent2(given.values[0], given.values[1], given.values[2]));
  return make_pose(moved.x, moved.y, moved.yaw);
}

/// One point or many, from the pose's own frame to the one that it lies in.
nb::object moved(const Pose2& a_T_b, const ArrayLike& points) {
  const Numbers given = numbers_of(points, "points");
  const bool is_one = given.shape == std::vector<std::size_t>{2};
  if (!is_one && (given.shape.size() != 2 || given.shape[1] != 2))
    throw nb::value_error("points: expected an array of shape (N, 2) or (2,)");
  std::vector<double> values;
  values.reserve(given.values.size());
  for (std::size_t i = 0; i + 1 < given.values.size(); i += 2) {
    const Eigen::Vector2d point = a_T_b * Eigen::Vector2d(given.values[i], given.values[i + 1]);
    values.insert(values.end(), {point.x(), point.y()});
  }
  if (is_one) return nb::cast(array_of<double, nb::ndim<1>>(std::move(values), given.shape));
  return nb::cast(array_of<double, nb::ndim<2>>(std::move(values), given.shape));
}

double item_of(const Pose2& pose, std::int64_t index) {
  const std::int64_t at = index < 0 ? index + 3 : index;
  if (at < 0 || at > 2) throw nb::index_error("a pose has x, y and yaw");
  return pose.vector()[at];
}

nb::object as_numpy(const Pose2& self, const nb::object& dtype, const nb::object& copy) {
  if (nb::isinstance<nb::bool_>(copy) && !nb::cast<bool>(copy))
    throw nb::value_error("an array of a pose is a copy");
  const nb::object array = nb::cast(to_array(self));
  return dtype.is_none() ? array : nb::object(array.attr("astype")(dtype));
}

void def_arithmetic(nb::class_<Pose2>& pose) {
  pose.def(
      "__matmul__", [](const Pose2& a_T_b, const Pose2& b_T_c) { return a_T_b * b_T_c; },
      nb::is_operator(), "``a_T_c = a_T_b @ b_T_c``.");
  pose.def("__matmul__", moved, nb::is_operator(),
           nb::sig("def __matmul__(self, points: numpy.typing.ArrayLike, /) -> "
                   "numpy.typing.NDArray[numpy.float64]"),
           "As :meth:`transform`.");
  pose.def("transform", moved, nb::arg("points"),
           nb::sig("def transform(self, points: numpy.typing.ArrayLike) -> "
                   "numpy.typing.NDArray[numpy.float64]"),
           "(N, 2) or (2,) points of the pose's own frame, in the frame that it lies in [m]. "
           "Points that\n"
           "are not finite stay so. Raises ValueError for another shape.");
  pose.def("inverse", &Pose2::inverse, "``b_T_a`` of ``a_T_b``.");
  pose.def(
      "between", [](const Pose2& self, const Pose2& other) { return self.inverse() * other; },
      nb::arg("other"), "The other one as seen from here: ``self.inverse() @ other``.");
  pose.def(
      "interpolate",
      [](const Pose2& self, const Pose2& other, double ratio) {
        return loopstone::interpolate(self, other, ratio);
      },
      nb::arg("other"), nb::arg("ratio"),
      "Along the arc to the other one: 0 is here, 1 is there; it goes on beyond both.");
  pose.def_static("exp", pose_by_twist, nb::arg("twist"),
                  "The motion along a twist (3,) [m, m, rad] for unit time: an arc.");
  def_array(
      pose, "twist",
      [](const Pose2& self) { return to_array(Eigen::Vector3d(loopstone::log(self))); },
      "(3,) of which this is exp().");
}

/// As a sequence of three numbers, which everything takes that takes a pose.
void def_numbers(nb::class_<Pose2>& pose) {
  pose.def("__len__", [](const Pose2& /*self*/) { return 3; });
  pose.def("__getitem__", item_of, nb::arg("index"));
  pose.def(
      "__iter__",
      [](const Pose2& self) { return nb::iter(nb::make_tuple(self.x, self.y, self.yaw)); },
      nb::sig("def __iter__(self) -> collections.abc.Iterator[float]"));
  pose.def("__array__", as_numpy, nb::arg("dtype") = nb::none(), nb::arg("copy") = nb::none(),
           nb::sig("def __array__(self, dtype: typing.Any = None, copy: bool | None = None) -> "
                   "numpy.typing.NDArray[typing.Any]"));
  // Else NumPy takes an array @ a pose for a product of matrices.
  pose.attr("__array_ufunc__") = nb::none();
  pose.def(
      "__eq__",
      [](const Pose2& self, nb::handle other) {
        return nb::isinstance<Pose2>(other) && self == nb::cast<const Pose2&>(other);
      },
      nb::arg("other").none(), nb::sig("def __eq__(self, other: object, /) -> bool"));
  pose.def("__hash__",
           [](const Pose2& self) { return nb::hash(nb::make_tuple(self.x, self.y, self.yaw)); });
  pose.def("__repr__", [](const Pose2& self) {
    return fmt::format("Pose({}, {}, {})", self.x, self.y, self.yaw);
  });
}

}  // namespace

void bind_pose(nb::module_& m) {
  nb::class_<Pose2> pose(
      m, "Pose",
      "A rigid motion of the plane: where frame b lies in frame a, ``a_T_b``. Can't be changed.\n\n"
      "Poses are arrays (3,) elsewhere; this is for who computes with them. Whatever takes a pose\n"
      "takes one of these.");
  pose.def(
      "__init__",
      [](Pose2* self, double x, double y, double yaw) { new (self) Pose2(make_pose(x, y, yaw)); },
      nb::arg("x") = 0.0, nb::arg("y") = 0.0, nb::arg("yaw") = 0.0,
      "x, y [m], yaw [rad]. Raises ValueError for what is not finite.");
  pose.def_static(
      "of", [](const ArrayLike& given) { return pose_of(given, "pose"); }, nb::arg("pose"),
      "Of an array (3,): x, y, yaw. Raises ValueError.");
  pose.def_ro("x", &Pose2::x, "[m]");
  pose.def_ro("y", &Pose2::y, "[m]");
  pose.def_ro("yaw", &Pose2::yaw, "[rad] counter-clockwise, in (-pi, pi].");
  def_array(
      pose, "matrix",
      [](const Pose2& self) {
        Eigen::MatrixXd matrix = Eigen::Matrix3d::Identity();
        matrix.topLeftCorner<2, 2>() = self.rotation();
        matrix.topRightCorner<2, 1>() = self.translation();
        return to_array(matrix);
      },
      "(3, 3) of homogeneous coordinates.");
  def_arithmetic(pose);
  def_numbers(pose);
}

}  // namespace loopstone::python
