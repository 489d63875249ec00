#pragma once

#include <cstddef>
#include <functional>

namespace loopstone {

/// How many threads a call may use. 0 = one for each processor.
struct Threads {
  int count = 0;

  /// count with 0 resolved; at least 1.
  [[nodiscard]] int resolved() const;
};

/// Calls body(i) once for each i in [0, count), on up to `threads` threads, in any order; returns
/// when all are done. body writes only to what belongs to i, so the result does not depend on the
/// number of threads. The first exception (lowest i among those thrown) is rethrown after all
/// running calls have ended.
void parallel_for(std::size_t count, Threads threads, const std::function<void(std::size_t)>& body);

}  // namespace loopstone
