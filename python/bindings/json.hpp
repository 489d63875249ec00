#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <string>

namespace loopstone::python {

/// What json.loads() makes of a text.
[[nodiscard]] inline nanobind::object parse_json(const std::string& text) {
  return nanobind::module_::import_("json").attr("loads")(text);
}

}  // namespace loopstone::python
