#pragma once

#include <nanobind/nanobind.h>

#include <string>

namespace loopstone::python {

/// A method that is written in Python: a function of a module that is imported when it is called.
/// \param signature  as type checkers see it
template <typename Class>
void def_python(nanobind::class_<Class>& cls, const char* name, const char* module,
                const char* function, const char* signature, const char* doc) {
  namespace nb = nanobind;
  cls.def(
      name,
      [module, function](nb::handle self, const nb::args& args, const nb::kwargs& kwargs) {
        return nb::module_::import_(module).attr(function)(self, *args, **kwargs);
      },
      nb::sig(signature), doc);
}

}  // namespace loopstone::python
