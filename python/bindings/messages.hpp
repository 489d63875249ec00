#pragma once

#include <nanobind/nanobind.h>

#include <optional>

#include "loopstone/sensor/messages.hpp"

namespace loopstone::python {

/// The message that an object is. Throws TypeError, naming the kinds that there are.
[[nodiscard]] SensorMessage message_of(nanobind::handle object);
/// As an object of its kind; what it holds is moved, not copied.
[[nodiscard]] nanobind::object to_object(SensorMessage message);

}  // namespace loopstone::python
