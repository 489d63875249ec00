#pragma once

#include <nanobind/nanobind.h>

#include <cstdint>

#include "loopstone/base/stamp.hpp"

namespace loopstone::python {

/// The stamp of a class that has one, in both of its forms.
template <typename Class>
void def_stamp(nanobind::class_<Class>& cls) {
  cls.def_prop_ro(
      "stamp_ns", [](const Class& self) { return self.stamp.nanoseconds; },
      "Nanoseconds of the recording's clock, exact.");
  cls.def_prop_ro(
      "stamp_s", [](const Class& self) { return self.stamp.seconds(); },
      "The same in seconds, which a float holds to some 0.2 us.");
}

}  // namespace loopstone::python
