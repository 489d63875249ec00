#include "reading.hpp"

#include <utility>

namespace loopstone::python {

LogSource Log::source(std::function<bool()> stop) const {
  LogSource source{.path = path, .how = how};
  source.how.stop = std::move(stop);
  if (robot) source.robot = robot->model;
  return source;
}

}  // namespace loopstone::python
