#pragma once

#include <Python.h>
#include <nanobind/nanobind.h>

#include <string>

namespace loopstone::python {

/// A path as an argument: text, or an object that has one.
struct PathLike {
  std::string value{};
};

}  // namespace loopstone::python

template <>
struct nanobind::detail::type_caster<loopstone::python::PathLike> {
  NB_TYPE_CASTER(loopstone::python::PathLike, const_name("str | os.PathLike[str]"))

  bool from_python(handle source, std::uint8_t /*flags*/, cleanup_list* /*cleanup*/) noexcept {
    PyObject* bytes = nullptr;
    if (PyUnicode_FSConverter(source.ptr(), &bytes) == 0) {
      PyErr_Clear();
      return false;
    }
    const object owner = steal(bytes);
    value.value.assign(PyBytes_AsString(bytes), static_cast<std::size_t>(PyBytes_Size(bytes)));
    return true;
  }
};
