#include "loopstone/formats/output_place.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <system_error>

#include "formats/atomic_file.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {

namespace fs = std::filesystem;

namespace {

/// Of a process that won't complete it. One that belongs to another user is alive, too.
bool is_left_over(const PartialName& partial) {
  if (partial.process == ::getpid()) return true;
  return ::kill(static_cast<pid_t>(partial.process), 0) != 0 && errno == ESRCH;
}

bool is_left_over(const fs::path& path) {
  const auto partial = parse_partial_name(path.filename().string());
  return partial && is_left_over(*partial);
}

}  // namespace

void require_room(const std::string& path, std::int64_t least_bytes) {
  { const AtomicFile probe(path); }
  const fs::path folder = fs::path(path).parent_path();
  std::error_code error;
  const fs::space_info space = fs::space(folder.empty() ? fs::path(".") : folder, error);
  const auto least = static_cast<std::uintmax_t>(std::max<std::int64_t>(least_bytes, 0));
  if (error || space.available >= least) return;
  throw DataError({path}, "there are " + std::to_string(space.available) +
                              " bytes left in its folder, and it needs " + std::to_string(least) +
                              " or more");
}

void require_free_name(const std::string& path) {
  std::error_code ignored;
  if (fs::exists(path, ignored))
    throw UsageError(path + ": is there already; it is overwritten when that is asked for");
}

void remove_partial_files(const std::string& folder, const std::string& name) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder.empty() ? "." : folder, error)) {
    const auto partial = parse_partial_name(entry.path().filename().string());
    if (!partial || (!name.empty() && partial->name != name) || !is_left_over(*partial)) continue;
    std::error_code ignored;
    fs::remove_all(entry.path(), ignored);
  }
}

bool holds_nothing(const std::string& folder) {
  std::error_code error;
  const fs::directory_iterator entries(folder, error);
  if (error) throw DataError({folder}, "cannot look into the folder: " + error.message());
  return std::all_of(begin(entries), end(entries),
                     [](const fs::directory_entry& entry) { return is_left_over(entry.path()); });
}

}  // namespace loopstone
