#include <algorithm>
#include <filesystem>

#include "loopstone/formats/log_format.hpp"
#include "loopstone/formats/log_format_words.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

/// By the ending; every other name is that of a folder.
const LogFormat& format_of_name(const std::string& name) {
  const LogFormat* folder = nullptr;
  for (const LogFormat& format : log_formats()) {
    if (!format.can_be_written()) continue;
    if (format.place == LogPlace::kFile && has_log_ending(format, name)) return format;
    if (format.place == LogPlace::kFolder && folder == nullptr) folder = &format;
  }
  if (folder == nullptr) throw UsageError("'" + name + "': no format of logs has such a name");
  return *folder;
}

/// Takes "#21" off the path.
void split_off_set(LogTarget& target) {
  const std::size_t hash = target.path.rfind('#');
  if (hash == target.path.npos) return;
  const std::string digits = target.path.substr(hash + 1);
  const bool is_number = !digits.empty() && digits.size() <= 6 &&
                         digits.find_first_not_of("0123456789") == digits.npos;
  if (!is_number) {
    throw UsageError("'" + target.path + "': after '#' the number of a set was expected");
  }
  target.set = std::stoi(digits);
  target.path.erase(hash);
}

[[noreturn]] void refuse_name(const std::string& path) {
  std::vector<std::string> places;
  for (const LogFormat& format : log_formats()) {
    if (format.place != LogPlace::kFile || !format.can_be_written()) continue;
    places.push_back("a " + std::string(format.endings.front()) + " file");
  }
  places.emplace_back("a folder");
  std::vector<std::string> flags = writable_log_formats();
  for (std::string& flag : flags) flag.insert(0, "--format ");
  throw UsageError("'" + path + "': the format does not follow from this name; write to " +
                   listed(places, "or") + ", or say " + listed(flags, "or"));
}

}  // namespace

LogTarget log_target(const std::string& path, const std::optional<std::string>& format) {
  LogTarget target{format ? &log_format(*format) : &format_of_name(path), path};
  if (!target.format->can_be_written()) {
    throw UsageError("logs of the format " + std::string(target.format->name) +
                     " are only read; written are " + listed(writable_log_formats(), "and"));
  }
  if (target.format->has_sets) split_off_set(target);
  std::error_code ignored;
  if (!format && target.format->place == LogPlace::kFolder &&
      fs::path(target.path).has_extension() && !fs::is_directory(target.path, ignored)) {
    refuse_name(target.path);
  }
  return target;
}

LogParts log_parts(const LogTarget& target) {
  if (target.format->parts != nullptr) return target.format->parts(target);
  return {.files = {target.path}};
}

}  // namespace loopstone
