#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>

#include "formats/byte_source.hpp"
#include "formats/carmen_reader.hpp"
#include "formats/log_path.hpp"
#include "formats/pipe_bytes.hpp"
#include "formats/ucsd_reader.hpp"
#include "loopstone/formats/log_reader.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

void refuse_known_others(const std::string& path, std::string_view magic) {
  const auto refuse = [&](const char* what) {
    throw DataError({path},
                    std::string("is ") + what +
                        ", which is not read; convert it to CARMEN text or the UCSD layout");
  };
  if (magic.starts_with("#ROSBAG")) refuse("a ROS 1 bag");
  if (magic.starts_with("SQLite format 3")) refuse("an SQLite file (a ROS 2 bag?)");
  if (magic.starts_with("\x89MCAP")) refuse("an MCAP file");
  if (magic.starts_with("\x89PNG")) refuse("a picture");
  if (magic.starts_with("MATLAB")) refuse("a MATLAB file");
  if (magic.starts_with("\x93NUMPY")) refuse("a single NumPy array");
}

}  // namespace

std::unique_ptr<LogReader> open_log(const std::string& path, const LogOptions& options) {
  const LogPath log = split_set(path);
  std::error_code ignored;
  if (path != kStandardInput && !fs::exists(log.path, ignored)) {
    throw DataError({log.path.string()}, "there is no such file or folder");
  }
  if (fs::is_directory(log.path, ignored)) return open_ucsd_log(log.path, log.set, options);
  if (log.set) {
    throw UsageError("'" + path + "': only a folder has sets, and " + log.path.string() +
                     " is a file");
  }
  char bytes[16] = {};
  const ReadableBytes content = open_file_or_pipe(log.path.string(), options.stop);
  const std::size_t count = read_fully(*content.look(0), bytes);
  const std::string_view magic(bytes, count);
  if (magic.empty()) throw DataError({content.name}, "the file is empty");
  if (magic.starts_with("PK") && !fs::is_regular_file(log.path, ignored)) {
    throw DataError({content.name}, "is an archive; a pipe can only hold a CARMEN log");
  }
  if (magic.starts_with("PK")) {
    const auto set = set_in_name(log.path.filename().string());
    if (!set) {
      throw DataError({log.path.string()},
                      "is an archive, but its name is not that of a sensor (EncodersN.npz, "
                      "HokuyoN.npz, ...)");
    }
    const fs::path folder = log.path.has_parent_path() ? log.path.parent_path() : fs::path(".");
    return open_ucsd_log(folder, set, options);
  }
  refuse_known_others(content.name, magic);
  return open_carmen_log(content, options);
}

}  // namespace loopstone
