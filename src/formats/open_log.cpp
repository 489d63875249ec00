#include <filesystem>

#include "formats/carmen_reader.hpp"
#include "loopstone/formats/log_reader.hpp"

namespace loopstone {

std::unique_ptr<LogReader> open_log(const std::string& path, const LogOptions& options) {
  return open_carmen_log(path, options);
}

}  // namespace loopstone
