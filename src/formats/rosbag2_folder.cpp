#include "formats/rosbag2_folder.hpp"

#include <algorithm>
#include <filesystem>
#include <set>
#include <string_view>
#include <system_error>

#include "formats/atomic_file.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPacked = ".zstd";
constexpr const char* kMetadata = "metadata.yaml";

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::string without_packing(std::string name) {
  if (name.ends_with(kPacked)) name.resize(name.size() - kPacked.size());
  return name;
}

/// Of a split, "run" of "run_12.db3"; the whole name without its ending when it has no number.
std::string series_of(const std::string& name) {
  std::string stem = fs::path(without_packing(name)).stem().string();
  std::size_t end = stem.size();
  while (end > 0 && is_digit(stem[end - 1])) --end;
  if (end < stem.size() && end > 0 && stem[end - 1] == '_') stem.resize(end - 1);
  return stem;
}

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

/// Names in the folder that a recording could consist of; of a file that lies there packed and
/// unpacked the latter, which rosbag2 leaves when it has played it.
std::vector<std::string> names_in(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (has_rosbag2_ending(name) && is_file(entry->path())) names.push_back(name);
  }
  const std::set<std::string> all(names.begin(), names.end());
  std::erase_if(names, [&all](const std::string& name) {
    return name.ends_with(kPacked) && all.contains(without_packing(name));
  });
  std::sort(names.begin(), names.end(), is_before_by_number);
  return names;
}

/// Where a file of metadata.yaml is now: in the folder, whatever path it had, rather than where it
/// was recorded.
std::optional<std::string> find_file(const fs::path& folder, const std::string& stated) {
  const fs::path path(stated);
  for (const fs::path& place : {folder / path.filename(), folder / path}) {
    const std::string name = place.string();
    for (const std::string& candidate :
         {name, name + std::string(kPacked), without_packing(name)}) {
      if (is_file(candidate)) return candidate;
    }
  }
  return std::nullopt;
}

void read_metadata(const fs::path& path, Rosbag2Folder& result) {
  if (!is_file(path)) {
    result.notes.push_back(
        "has no metadata.yaml: the files are read in the order of their numbers");
    return;
  }
  try {
    constexpr std::size_t kMostBytes = std::size_t{1} << 24;
    result.metadata =
        parse_rosbag2_metadata(read_whole_file(path.string(), kMostBytes), path.string());
  } catch (const DataError& error) {
    std::string reason = error.what();
    const std::string where = to_string(error.location()) + ": ";
    if (reason.starts_with(where)) reason.erase(0, where.size());
    result.problems.push_back({error.location(), reason});
  }
}

void add_listed(const fs::path& folder, Rosbag2Folder& result) {
  std::set<std::string> seen;
  for (const std::string& stated : result.metadata->files) {
    const auto file = find_file(folder, stated);
    if (!file) {
      result.missing.push_back(stated);
    } else if (seen.insert(*file).second) {
      result.files.push_back(*file);
    }
  }
}

/// A recorder that was killed did not list its last files.
void add_unlisted(const fs::path& folder, const std::vector<std::string>& names,
                  Rosbag2Folder& result) {
  std::set<std::string> listed;
  std::set<std::string> series;
  std::string last;
  for (const std::string& stated : result.metadata->files) {
    const std::string name = without_packing(fs::path(stated).filename().string());
    listed.insert(name);
    series.insert(series_of(name));
    if (last.empty() || is_before_by_number(last, name)) last = name;
  }
  for (const std::string& name : names) {
    if (listed.contains(without_packing(name))) continue;
    if (series.contains(series_of(name)) && is_before_by_number(last, name)) {
      result.files.push_back((folder / name).string());
      result.notes.push_back(name + " is read, too, though metadata.yaml does not list it");
    } else {
      result.notes.push_back(name + " is not read: metadata.yaml does not list it");
    }
  }
}

}  // namespace

bool has_rosbag2_ending(const std::string& name) {
  const std::string plain = without_packing(name);
  return plain.ends_with(".db3") || plain.ends_with(".mcap");
}

bool is_before_by_number(const std::string& a, const std::string& b) {
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      const auto number = [](const std::string& text, std::size_t& at) {
        while (at + 1 < text.size() && text[at] == '0' && is_digit(text[at + 1])) ++at;
        const std::size_t begin = at;
        while (at < text.size() && is_digit(text[at])) ++at;
        return std::string_view(text).substr(begin, at - begin);
      };
      const std::string_view first = number(a, i);
      const std::string_view second = number(b, j);
      if (first.size() != second.size()) return first.size() < second.size();
      if (first != second) return first < second;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
    }
  }
  if (i == a.size() && j == b.size()) return a < b;
  return i == a.size();
}

Rosbag2Folder look_at_rosbag2_folder(const std::string& folder) {
  Rosbag2Folder result;
  const std::vector<std::string> names = names_in(folder);
  const fs::path metadata = fs::path(folder) / kMetadata;
  std::error_code ignored;
  if (names.empty() && !fs::exists(metadata, ignored)) return result;
  read_metadata(metadata, result);
  if (result.metadata) add_listed(folder, result);
  if (!result.files.empty()) {
    add_unlisted(folder, names, result);
    return result;
  }
  if (result.metadata && !names.empty()) {
    result.notes.push_back(
        "none of the files that metadata.yaml lists is here: those that are, are "
        "read in the order of their numbers");
    result.missing.clear();
  }
  for (const std::string& name : names) result.files.push_back((fs::path(folder) / name).string());
  return result;
}

}  // namespace loopstone
