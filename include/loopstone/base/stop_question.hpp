#pragma once

#include <functional>

namespace loopstone {

/// Asked now and then while something long goes on, by the thread that does it; true ends it at the
/// next good place. May be empty.
using StopQuestion = std::function<bool()>;

[[nodiscard]] inline bool is_stopped(const StopQuestion& stop) { return stop && stop(); }

}  // namespace loopstone
