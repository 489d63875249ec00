#include "loopstone/formats/log_files.hpp"

#include <system_error>

#include "formats/log_path.hpp"
#include "loopstone/formats/log_format.hpp"

namespace loopstone {

namespace fs = std::filesystem;

namespace {

/// A folder's format is told by the names in it; a file may be one of several by its own name.
std::vector<std::string> files_of(const LogInput& log) {
  if (log.is_folder) {
    const LogFormat& format = recognise_log(log);
    if (format.files != nullptr) return format.files(log);
    return {log.path.string()};
  }
  for (const LogFormat& format : log_formats()) {
    if (format.files == nullptr) continue;
    if (auto files = format.files(log); !files.empty()) return files;
  }
  return {log.path.string()};
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
  const LogInput input{.name = log,
                       .path = path.path,
                       .set = path.set,
                       .is_folder = fs::is_directory(path.path, ignored)};
  for (const std::string& file : files_of(input)) files_.push_back(look_at(file));
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
