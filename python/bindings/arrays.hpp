#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "loopstone/geometry/polygon.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/geometry/pose3.hpp"

// NumPy arrays in and out. What comes in may be anything that numpy.asarray() takes; it is checked
// here, and an error names the argument. What goes out is either a view, which is read-only and
// keeps its owner alive, or an array of its own.

namespace loopstone::python {

namespace nb = nanobind;

/// An argument that numpy.asarray() takes.
struct ArrayLike {
  nb::object value{};
};

/// Its numbers as doubles, row by row.
struct Numbers {
  std::vector<double> values{};
  std::vector<std::size_t> shape{};
};

/// Throws ValueError, naming the argument, for what are no numbers.
[[nodiscard]] Numbers numbers_of(const ArrayLike& argument, std::string_view name);

/// The same of whole numbers. Throws ValueError for others.
struct Integers {
  std::vector<std::int64_t> values{};
  std::vector<std::size_t> shape{};
};
[[nodiscard]] Integers integers_of(const ArrayLike& argument, std::string_view name);

/// (x, y, yaw). Throws ValueError for another shape, and for what is not finite.
[[nodiscard]] Pose2 pose_of(const ArrayLike& argument, std::string_view name);
/// (N, 3). Throws as pose_of().
[[nodiscard]] std::vector<Pose2> poses_of(const ArrayLike& argument, std::string_view name);
/// A 4 x 4 matrix. Throws ValueError for one that is no rigid motion.
[[nodiscard]] Pose3 pose3_of(const ArrayLike& argument, std::string_view name);
/// (N, 2). What is not finite is kept: points without return. Throws ValueError for another shape.
[[nodiscard]] std::vector<Eigen::Vector2d> points2_of(const ArrayLike& argument,
                                                      std::string_view name);
/// (N, 3), likewise.
[[nodiscard]] std::vector<Eigen::Vector3d> points3_of(const ArrayLike& argument,
                                                      std::string_view name);
/// Columns of (N, 2) or (N, 3) points; 0 for everything else.
[[nodiscard]] std::size_t columns_of(const ArrayLike& argument, std::string_view name);
[[nodiscard]] std::vector<float> floats_of(const ArrayLike& argument, std::string_view name);

template <typename T, typename... Shape>
using View = nb::ndarray<nb::numpy, const T, nb::ro, Shape...>;
template <typename T, typename... Shape>
using Array = nb::ndarray<nb::numpy, T, Shape...>;

/// Read-only, without a copy. \param owner  keeps the memory; must not change it any more
template <typename T>
[[nodiscard]] View<T, nb::ndim<1>> view_of(std::span<const T> values, nb::handle owner) {
  return View<T, nb::ndim<1>>(values.data(), {values.size()}, owner);
}

/// An array that owns what it shows.
template <typename T, typename... Shape>
[[nodiscard]] Array<T, Shape...> array_of(std::vector<T> values, std::vector<std::size_t> shape) {
  auto kept = std::make_unique<std::vector<T>>(std::move(values));
  T* const data = kept->data();
  nb::capsule owner(kept.get(), [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  (void)kept.release();
  return Array<T, Shape...>(data, shape.size(), shape.data(), owner);
}

using Vector = Array<double, nb::ndim<1>>;
using Matrix = Array<double, nb::ndim<2>>;

[[nodiscard]] Vector to_array(const Pose2& pose);
[[nodiscard]] Vector to_array(const Eigen::Vector2d& point);
[[nodiscard]] Vector to_array(const Eigen::Vector3d& vector);
/// (rows, columns), whatever the order in memory.
[[nodiscard]] Matrix to_array(const Eigen::MatrixXd& matrix);
/// (N, 3).
[[nodiscard]] Matrix to_array(std::span<const Pose2> poses);
/// (N, 2).
[[nodiscard]] Matrix corners_of(const Polygon2& polygon);

/// A property that is an array, be it a view or made when it is asked for.
template <typename Class, typename Getter, typename... Extra>
void def_array(nb::class_<Class>& cls, const char* name, Getter&& getter, const Extra&... extra) {
  cls.def_prop_ro(name, std::forward<Getter>(getter), nb::rv_policy::automatic, extra...);
}

}  // namespace loopstone::python

template <>
struct nanobind::detail::type_caster<loopstone::python::ArrayLike> {
  NB_TYPE_CASTER(loopstone::python::ArrayLike, const_name("numpy.typing.ArrayLike"))

  bool from_python(handle source, std::uint8_t /*flags*/, cleanup_list* /*cleanup*/) noexcept {
    if (source.is_none()) return false;
    value.value = borrow(source);
    return true;
  }
};
