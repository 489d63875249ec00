#include "loopstone/formats/log_files.hpp"

#include <initializer_list>
#include <optional>
#include <system_error>

#include "formats/log_path.hpp"
#include "formats/ucsd_files.hpp"

namespace loopstone {

namespace fs = std::filesystem;

namespace {

/// Nothing when the log is a single file.
std::optional<UcsdFiles> set_of(const LogPath& log) {
  std::error_code ignored;
  if (fs::is_directory(log.path, ignored)) return find_ucsd_files(log.path, log.set);
  const auto set = set_in_name(log.path.filename().string());
  if (log.path.extension() != ".npz" || !set) return std::nullopt;
  const fs::path folder = log.path.has_parent_path() ? log.path.parent_path() : fs::path(".");
  return find_ucsd_files(folder, set);
}

}  // namespace

LogFiles::File LogFiles::look_at(const std::string& path) {
  std::error_code error;
  File file{.path = path};
  file.is_regular = fs::is_regular_file(path, error);
  if (!file.is_regular) return file;
  const std::uintmax_t bytes = fs::file_size(path, error);
  if (!error) file.bytes = static_cast<std::int64_t>(bytes);
  file.written = fs::last_write_time(path, error);
  return file;
}

LogFiles::LogFiles(const std::string& log) {
  const LogPath path = split_set(log);
  std::error_code ignored;
  if (!fs::exists(path.path, ignored)) return;
  const auto set = set_of(path);
  if (!set) {
    files_.push_back(look_at(path.path.string()));
    return;
  }
  for (const fs::path& part : {set->encoders, set->imu, set->hokuyo, set->kinect, set->odometry}) {
    if (!part.empty()) files_.push_back(look_at(part.string()));
  }
}

std::vector<std::string> LogFiles::paths() const {
  std::vector<std::string> paths;
  for (const File& file : files_) paths.push_back(file.path);
  return paths;
}

std::int64_t LogFiles::bytes() const {
  std::int64_t sum = 0;
  for (const File& file : files_) sum += file.bytes;
  return sum;
}

std::vector<std::string> LogFiles::changes() const {
  std::vector<std::string> changes;
  for (const File& was : files_) {
    if (!was.is_regular) continue;
    const File is = look_at(was.path);
    if (!is.is_regular) {
      changes.push_back(was.path + ": was removed while it was read");
    } else if (is.bytes != was.bytes) {
      changes.push_back(was.path + ": " + (is.bytes < was.bytes ? "shrank" : "grew") +
                        " while it was read, from " + std::to_string(was.bytes) + " to " +
                        std::to_string(is.bytes) +
                        " bytes; the result is of what was there in time, run again for the whole");
    } else if (is.written != was.written) {
      changes.push_back(was.path + ": was written to while it was read; its size is the same, " +
                        std::to_string(is.bytes) + " bytes, the result may be of a mixture");
    }
  }
  return changes;
}

}  // namespace loopstone
