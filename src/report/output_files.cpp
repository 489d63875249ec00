#include "report/output_files.hpp"

#include <future>
#include <system_error>

#include "loopstone/base/error.hpp"

namespace loopstone {

namespace fs = std::filesystem;

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

void FileSet::commit() {
  // A disk takes about as long to make one file safe as to make all of them safe at once.
  std::vector<std::future<void>> safe;
  safe.reserve(files_.size());
  for (AtomicFile& file : files_) {
    safe.push_back(std::async(std::launch::async, [&file] { file.finish_writing(); }));
  }
  for (auto& done : safe) done.get();
  for (AtomicFile& file : files_) file.commit();
}

}  // namespace loopstone
