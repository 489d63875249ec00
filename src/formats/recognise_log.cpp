#include <array>
#include <string_view>
#include <system_error>
#include <utility>

#include "formats/byte_source.hpp"
#include "formats/byte_stream.hpp"
#include "formats/log_head.hpp"
#include "formats/log_path.hpp"
#include "loopstone/formats/log_format.hpp"
#include "loopstone/formats/log_format_words.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

/// Files that are known not to be logs, or not of a format that is read: told what they are.
struct ForeignFile {
  std::string_view mark;  ///< first bytes
  std::string_view what;
};
constexpr std::array<ForeignFile, 3> kForeignFiles{{
    {"\x89PNG", "a picture"},
    {"MATLAB", "a MATLAB file"},
    {"\x93NUMPY", "a single NumPy array"},
}};

/// Of somebody who named the folder and meant what lies in it.
std::string hint_at_file(const LogInput& log, const LogFormat& format) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(log.path, ignored)) {
    if (!has_log_ending(format, entry.path().filename().string())) continue;
    return "; if you meant the file in it, give its name: " + entry.path().string();
  }
  return {};
}

[[noreturn]] void refuse_folder(const LogInput& log) {
  std::vector<std::string> expected;
  std::string hint;
  for (const LogFormat& format : log_formats()) {
    if (format.place == LogPlace::kFolder) expected.emplace_back(format.expected);
    if (format.place == LogPlace::kFile && hint.empty()) hint = hint_at_file(log, format);
  }
  throw DataError({log.path.string()},
                  "the folder holds no log: " + listed(expected, "or") + " was expected" + hint);
}

void refuse_foreign(const LogInput& log) {
  for (const ForeignFile& file : kForeignFiles) {
    if (!log.head.starts_with(file.mark)) continue;
    std::vector<std::string> nouns;
    for (const LogFormat& format : log_formats()) nouns.emplace_back(format.noun);
    throw DataError({log.name}, "is " + std::string(file.what) + ", which is not read; convert " +
                                    "it to " + listed(nouns, "or"));
  }
}

}  // namespace

LogInput look_at_log(const std::string& path, std::function<bool()> stop) {
  const LogPath parts = split_set(path);
  std::error_code ignored;
  if (path != kStandardInput && !fs::exists(parts.path, ignored)) {
    throw DataError({parts.path.string()}, "there is no such file or folder");
  }
  LogInput log{.name = parts.path.string(), .path = parts.path, .set = parts.set};
  log.is_folder = fs::is_directory(log.path, ignored);
  if (log.is_folder) return log;
  if (log.set) {
    throw UsageError("'" + path + "': only a folder has sets, and " + log.path.string() +
                     " is a file");
  }
  log.content =
      std::make_shared<ReadableBytes>(open_file_or_pipe(log.path.string(), std::move(stop)));
  log.name = log.content->name;
  log.is_stream = !fs::is_regular_file(log.path, ignored);
  log.head = head_of(*log.content);
  if (log.head.empty()) throw DataError({log.name}, "the file is empty");
  return log;
}

const LogFormat& recognise_log(const LogInput& log) {
  const LogFormat* surest = nullptr;
  Recognition sure = Recognition::kNo;
  for (const LogFormat& format : log_formats()) {
    const Recognition recognition = format.recognise(log);
    if (recognition <= sure) continue;
    surest = &format;
    sure = recognition;
  }
  if (surest == nullptr && log.is_folder) refuse_folder(log);
  // What only may be a log is none when it is known to be something else.
  if (sure != Recognition::kCertain) refuse_foreign(log);
  if (surest == nullptr) {
    throw DataError({log.name}, "is no log; expected was " + what_a_log_is());
  }
  return *surest;
}

}  // namespace loopstone
