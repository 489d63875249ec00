#include "arrays.hpp"

#include <nanobind/stl/string.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>
#include <type_traits>

#include "loopstone/geometry/angle.hpp"

namespace loopstone::python {

namespace {

[[noreturn]] void refuse(std::string_view name, const std::string& why) {
  throw nb::value_error((std::string(name) + ": " + why).c_str());
}

std::string to_string(const std::vector<std::size_t>& shape) {
  std::string text = "(";
  for (std::size_t i = 0; i < shape.size(); ++i)
    text += (i == 0 ? "" : ", ") + std::to_string(shape[i]);
  return text + (shape.size() == 1 ? ",)" : ")");
}

template <typename List>
void require_shape(const List& numbers, bool right, std::string_view name,
                   const std::string& expected) {
  if (right) return;
  refuse(name, "expected an array of shape " + expected + ", not " + to_string(numbers.shape));
}

void require_finite(const Numbers& numbers, std::string_view name) {
  for (const double value : numbers.values) {
    if (!std::isfinite(value)) refuse(name, "must hold finite numbers only, no NaN or infinity");
  }
}

template <int kColumns>
std::vector<Eigen::Matrix<double, kColumns, 1>> points_of(const ArrayLike& argument,
                                                          std::string_view name) {
  const Numbers numbers = numbers_of(argument, name);
  require_shape(numbers, numbers.shape.size() == 2 && numbers.shape[1] == kColumns, name,
                "(N, " + std::to_string(kColumns) + ")");
  std::vector<Eigen::Matrix<double, kColumns, 1>> points(numbers.shape[0]);
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i] = Eigen::Map<const Eigen::Matrix<double, kColumns, 1>>(&numbers.values[i * kColumns]);
  return points;
}

template <typename T>
using Contiguous = nb::ndarray<const T, nb::c_contig, nb::device::cpu>;

/// numpy.asarray() of numbers, not of texts and objects. nanobind alone is not asked: it does not
/// survive every object of NumPy.
/// \param kinds    of dtypes that will do
/// \param expected  in words
template <typename T>
Contiguous<T> as_array(const ArrayLike& argument, std::string_view name, std::string_view kinds,
                       const std::string& expected) {
  nb::object array;
  try {
    const nb::module_ numpy = nb::module_::import_("numpy");
    const nb::object given = numpy.attr("asarray")(argument.value);
    const std::string kind = nb::cast<std::string>(given.attr("dtype").attr("kind"));
    const bool is_empty = nb::cast<std::size_t>(given.attr("size")) == 0;
    if (kind.find_first_of(kinds) == std::string::npos && !is_empty) {
      refuse(name, "expected " + expected + ", not an array of dtype " +
                       nb::cast<std::string>(given.attr("dtype").attr("name")));
    }
    array = numpy.attr("ascontiguousarray")(
        given, numpy.attr(std::is_same_v<T, double> ? "float64" : "int64"));
    // ascontiguousarray() makes a single number an array of one.
    array = array.attr("reshape")(given.attr("shape"));
  } catch (nb::python_error& error) {
    if (!error.matches(PyExc_ValueError) && !error.matches(PyExc_TypeError)) throw;
    refuse(name, "expected an array of numbers, not " +
                     nb::cast<std::string>(
                         nb::handle(reinterpret_cast<PyObject*>(Py_TYPE(argument.value.ptr())))
                             .attr("__name__")));
  }
  return nb::cast<Contiguous<T>>(array);
}

Contiguous<double> real_numbers(const ArrayLike& argument, std::string_view name) {
  return as_array<double>(argument, name, "iuf", "real numbers");
}

template <typename List, typename T>
List list_of(const Contiguous<T>& array) {
  List list;
  for (std::size_t i = 0; i < array.ndim(); ++i) list.shape.push_back(array.shape(i));
  list.values.assign(array.data(), array.data() + array.size());
  return list;
}

}  // namespace

Numbers numbers_of(const ArrayLike& argument, std::string_view name) {
  return list_of<Numbers>(real_numbers(argument, name));
}

Integers integers_of(const ArrayLike& argument, std::string_view name) {
  return list_of<Integers>(as_array<std::int64_t>(argument, name, "iu", "whole numbers"));
}

Pose2 pose_of(const ArrayLike& argument, std::string_view name) {
  const Numbers numbers = numbers_of(argument, name);
  require_shape(numbers, numbers.shape == std::vector<std::size_t>{3}, name, "(3,): x, y, yaw");
  require_finite(numbers, name);
  return {numbers.values[0], numbers.values[1], wrap_angle(numbers.values[2])};
}

std::vector<Pose2> poses_of(const ArrayLike& argument, std::string_view name) {
  const Numbers numbers = numbers_of(argument, name);
  require_shape(numbers, numbers.shape.size() == 2 && numbers.shape[1] == 3, name,
                "(N, 3): x, y, yaw");
  require_finite(numbers, name);
  std::vector<Pose2> poses(numbers.shape[0]);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double* row = &numbers.values[3 * i];
    poses[i] = {row[0], row[1], wrap_angle(row[2])};
  }
  return poses;
}

Pose3 pose3_of(const ArrayLike& argument, std::string_view name) {
  const Numbers numbers = numbers_of(argument, name);
  require_shape(numbers, numbers.shape == std::vector<std::size_t>{4, 4}, name, "(4, 4)");
  require_finite(numbers, name);
  using RowMajor = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
  const Eigen::Matrix4d matrix = Eigen::Map<const RowMajor>(numbers.values.data());
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  constexpr double kRounding = 1e-4;  // of matrices that were written with few digits
  const bool is_rigid = (rotation * rotation.transpose()).isIdentity(kRounding) &&
                        rotation.determinant() > 0.0 &&
                        (matrix.row(3) - Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0)).norm() < kRounding;
  if (!is_rigid) refuse(name, "must be a rigid motion: a rotation, a translation, 0 0 0 1 below");
  Pose3 pose;
  pose.rotation = Eigen::Quaterniond(rotation).normalized();
  pose.translation = matrix.topRightCorner<3, 1>();
  return pose;
}

std::vector<Eigen::Vector2d> points2_of(const ArrayLike& argument, std::string_view name) {
  return points_of<2>(argument, name);
}

std::vector<Eigen::Vector3d> points3_of(const ArrayLike& argument, std::string_view name) {
  return points_of<3>(argument, name);
}

std::size_t columns_of(const ArrayLike& argument, std::string_view name) {
  const Contiguous<double> array = real_numbers(argument, name);
  if (array.ndim() == 2 && (array.shape(1) == 2 || array.shape(1) == 3)) return array.shape(1);
  return 0;
}

std::vector<float> floats_of(const ArrayLike& argument, std::string_view name) {
  const Numbers numbers = numbers_of(argument, name);
  require_shape(numbers, numbers.shape.size() == 1, name, "(N,)");
  return {numbers.values.begin(), numbers.values.end()};
}

Vector to_array(const Pose2& pose) {
  return array_of<double, nb::ndim<1>>({pose.x, pose.y, pose.yaw}, {3});
}

Vector to_array(const Eigen::Vector2d& point) {
  return array_of<double, nb::ndim<1>>({point.x(), point.y()}, {2});
}

Vector to_array(const Eigen::Vector3d& vector) {
  return array_of<double, nb::ndim<1>>({vector.x(), vector.y(), vector.z()}, {3});
}

Matrix to_array(const Eigen::MatrixXd& matrix) {
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(matrix.size()));
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = 0; column < matrix.cols(); ++column)
      values.push_back(matrix(row, column));
  }
  return array_of<double, nb::ndim<2>>(
      std::move(values),
      {static_cast<std::size_t>(matrix.rows()), static_cast<std::size_t>(matrix.cols())});
}

Matrix to_array(std::span<const Pose2> poses) {
  std::vector<double> values;
  values.reserve(3 * poses.size());
  for (const Pose2& pose : poses) values.insert(values.end(), {pose.x, pose.y, pose.yaw});
  return array_of<double, nb::ndim<2>>(std::move(values), {poses.size(), 3});
}

Matrix corners_of(const Polygon2& polygon) {
  std::vector<double> values;
  values.reserve(2 * polygon.corners.size());
  for (const Eigen::Vector2d& corner : polygon.corners)
    values.insert(values.end(), {corner.x(), corner.y()});
  return array_of<double, nb::ndim<2>>(std::move(values), {polygon.corners.size(), 2});
}

}  // namespace loopstone::python
