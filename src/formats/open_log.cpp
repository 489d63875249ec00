#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>

#include "formats/byte_source.hpp"
#include "formats/carmen_reader.hpp"
#include "formats/text_numbers.hpp"
#include "formats/ucsd_reader.hpp"
#include "loopstone/formats/log_reader.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

struct LogPath {
  fs::path path;
  std::optional<int> set{};
};

/// Cuts off "#20", unless a file has that very name.
LogPath split_set(const std::string& path) {
  const std::size_t hash = path.rfind('#');
  std::error_code ignored;
  if (hash == path.npos || fs::exists(path, ignored)) return {path};
  const auto set = parse_integer(std::string_view(path).substr(hash + 1));
  if (!set || *set < 0 || *set > 1'000'000) {
    throw UsageError("'" + path + "': after '#' the number of a set was expected");
  }
  return {path.substr(0, hash), static_cast<int>(*set)};
}

/// "Hokuyo20.npz" -> 20.
std::optional<int> set_in_name(const std::string& name) {
  const std::size_t end = name.rfind('.');
  std::size_t begin = end;
  while (begin != name.npos && begin > 0 && name[begin - 1] >= '0' && name[begin - 1] <= '9') {
    --begin;
  }
  if (end == name.npos || begin == end) return std::nullopt;
  const auto set = parse_integer(std::string_view(name).substr(begin, end - begin));
  if (!set || *set > 1'000'000) return std::nullopt;
  return static_cast<int>(*set);
}

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
  if (!fs::exists(log.path, ignored)) {
    throw DataError({log.path.string()}, "there is no such file or folder");
  }
  if (fs::is_directory(log.path, ignored)) return open_ucsd_log(log.path, log.set, options);
  if (log.set) {
    throw UsageError("'" + path + "': only a folder has sets, and " + log.path.string() +
                     " is a file");
  }
  char bytes[16] = {};
  const std::size_t count = open_byte_source(log.path.string())->read(bytes);
  const std::string_view magic(bytes, count);
  if (magic.empty()) throw DataError({log.path.string()}, "the file is empty");
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
  refuse_known_others(log.path.string(), magic);
  return open_carmen_log(log.path.string(), options);
}

}  // namespace loopstone
