#include "formats/carmen_writer.hpp"
#include "formats/ucsd_writer.hpp"
#include "loopstone/formats/log_reader.hpp"

namespace loopstone {

std::unique_ptr<LogWriter> create_log(const std::string& path, const std::string& format,
                                      const RobotModel& robot, int set) {
  if (format == "carmen") return create_carmen_log(path, robot);
  if (format == "ucsd") return create_ucsd_log(path, robot, set);
  throw UsageError("there is no log format '" + format + "'; there are carmen and ucsd");
}

}  // namespace loopstone
