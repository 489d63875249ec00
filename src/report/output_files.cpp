#include "report/output_files.hpp"

#include <algorithm>
#include <future>
#include <system_error>

#include "loopstone/base/error.hpp"

namespace loopstone {

namespace fs = std::filesystem;

namespace {

constexpr char kSummary[] = "summary.json";
/// Stands in summary.json while an older set is replaced.
constexpr std::string_view kReplacing =
    "{\n  \"complete\": false,\n  \"warnings\": [\"a run was ended while it replaced the files of "
    "another one: they are of both\"]\n}\n";
/// Everything but summary.json that map, texture and localize leave.
constexpr const char* kResultNames[] = {
    "trajectory.tum",    "odometry.tum",   "graph.g2o",       "loop_closures.csv",
    "options.toml",      "decisions.toml", "map.png",         "map.pgm",
    "map.yaml",          "quality.png",    "texture.png",     "texture.yaml",
    "texture.pgw",       "coverage.png",   "texture_map.png", "cloud.ply",
    "localization.csv",  "trajectory.csv", "report.html",     "keepout_mask.pgm",
    "keepout_mask.yaml", "speed_mask.pgm", "speed_mask.yaml", "nav2_filters.yaml",
};

}  // namespace

OutputFolder::OutputFolder(const std::string& path, bool force) : path_(path) {
  std::error_code error;
  const fs::file_status status = fs::status(path_, error);
  if (fs::exists(status) && !fs::is_directory(status))
    throw UsageError(path + ": is a file; the output must be a folder");
  if (!fs::exists(status)) {
    fs::create_directories(path_, error);
    if (error) throw DataError({path}, "cannot make this folder: " + error.message());
    made_ = true;
    return;
  }
  const fs::directory_iterator first(path_, error);
  if (error) throw DataError({path}, "cannot open this folder: " + error.message());
  if (!force && first != fs::directory_iterator()) {
    throw UsageError(path + ": holds files already; choose another folder or add --force");
  }
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  if (made_ && !kept_) fs::remove(path_, ignored);  // only when empty
}

bool OutputFolder::holds(const std::string& name) const {
  std::error_code ignored;
  return fs::exists(path_ / name, ignored);
}

void FileSet::add(const std::string& name, const std::string& content, std::string_view bytes) {
  AtomicFile& file = files_.emplace_back(folder_.file(name));
  file.write(bytes);
  listed_.push_back({name, content, static_cast<std::int64_t>(bytes.size())});
}

void FileSet::add(const std::string& name, const std::string& content,
                  const std::function<void(AtomicFile&)>& write) {
  AtomicFile& file = files_.emplace_back(folder_.file(name));
  write(file);
  file.finish_writing();
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(file.temporary_path(), error);
  listed_.push_back({name, content, error ? 0 : static_cast<std::int64_t>(bytes)});
}

void FileSet::make_safe() {
  // A disk takes about as long to make one file safe as to make all of them safe at once.
  std::vector<std::future<void>> safe;
  safe.reserve(files_.size());
  for (AtomicFile& file : files_) {
    safe.push_back(std::async(std::launch::async, [&file] { file.finish_writing(); }));
  }
  for (auto& done : safe) done.get();
  safe_ = files_.size();
}

void FileSet::forget_the_rest() {
  while (files_.size() > safe_) files_.pop_back();
  listed_.resize(safe_);
}

void FileSet::clear_old_set() const {
  if (!folder_.holds(kSummary)) return;  // files that are nobody's results are not ours to remove
  write_file_atomically(folder_.file(kSummary), kReplacing);
  for (const char* const name : kResultNames) {
    const bool comes_anew = std::any_of(listed_.begin(), listed_.end(),
                                        [&](const ListedFile& file) { return file.name == name; });
    std::error_code ignored;
    if (!comes_anew) fs::remove(folder_.file(name), ignored);
  }
}

void FileSet::commit() {
  make_safe();
  clear_old_set();
  const auto commit_if = [&](bool is_summary) {
    for (std::size_t i = 0; i < files_.size(); ++i) {
      if ((listed_[i].name == kSummary) == is_summary) files_[i].commit();
    }
  };
  commit_if(false);
  commit_if(true);
}

}  // namespace loopstone
