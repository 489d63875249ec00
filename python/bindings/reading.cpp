#include "reading.hpp"

namespace loopstone::python {

std::unique_ptr<LogReader> Log::open(std::function<bool()> stop) const {
  LogOptions options = how;
  options.stop = std::move(stop);
  return open_log(path, options);
}

std::unique_ptr<LogReader> Log::open_ahead(std::function<bool()> stop, bool pictures) const {
  LogOptions options = how;
  options.stop = std::move(stop);
  options.topics.pictures = pictures;
  return open_log_ahead(path, options);
}

RobotModel Log::robot_of(const LogReader& reader) const {
  if (!robot) return reader.robot(RobotModel{});
  RobotModel model = robot->model;
  model.wheels = reader.wheels(model.wheels);
  return model;
}

}  // namespace loopstone::python
