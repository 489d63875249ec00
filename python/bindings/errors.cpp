#include <Python.h>
#include <nanobind/stl/string.h>

#include <exception>
#include <string>

#include "bindings.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/option_list.hpp"
#include "loopstone/formats/log_reader.hpp"

namespace loopstone::python {

namespace {

/// A class of loopstone._errors, which is not imported before something fails.
nb::object error_class(const char* name) {
  return nb::module_::import_("loopstone._errors").attr(name);
}

void raise(const nb::object& error) {
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(error.ptr())), error.ptr());
}

template <typename Number>
nb::object or_none(const std::optional<Number>& number) {
  return number ? nb::object(nb::int_(*number)) : nb::none();
}

nb::object of_data(const DataError& error) {
  const Location& where = error.location();
  return error_class("data_error")(error.what(), where.path, or_none(where.line),
                                   or_none(where.byte_offset));
}

nb::object of_options(const OptionsError& error) {
  nb::list problems;
  for (const OptionProblem& problem : error.problems()) {
    problems.append(error_class("OptionProblem")(problem.key, problem.value, problem.rule,
                                                 problem.where.path, or_none(problem.where.line)));
  }
  return error_class("OptionsError")(error.what(), nb::tuple(problems));
}

void translate(const std::exception_ptr& thrown, void* /*unused*/) {
  try {
    std::rethrow_exception(thrown);
  } catch (const OptionsError& error) {
    raise(of_options(error));
  } catch (const UsageError& error) {
    raise(error_class("UsageError")(error.what()));
  } catch (const DataError& error) {
    raise(of_data(error));
  } catch (const ReadingStopped&) {
    // Whoever asked for it has set the reason: Ctrl-C.
    if (PyErr_Occurred() == nullptr) PyErr_SetNone(PyExc_KeyboardInterrupt);
  }
}

}  // namespace

void bind_errors(nb::module_& /*m*/) { nb::register_exception_translator(translate); }

}  // namespace loopstone::python
