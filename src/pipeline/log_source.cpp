#include "loopstone/pipeline/log_source.hpp"

namespace loopstone {

std::unique_ptr<LogReader> LogSource::open() const { return open_log(path, how); }

std::unique_ptr<LogReader> LogSource::open_ahead(Threads threads) const {
  return threads.resolved() > 1 ? open_log_ahead(path, how) : open_log(path, how);
}

std::unique_ptr<LogReader> LogSource::open_again() const {
  LogOptions again = how;
  again.on_problem = {};
  again.topics.pictures = false;
  return open_log(path, again);
}

RobotModel LogSource::robot_of(const LogReader& reader) const {
  if (!robot) return reader.robot(RobotModel{});
  RobotModel model = *robot;
  model.wheels = reader.wheels(model.wheels);
  return model;
}

}  // namespace loopstone
