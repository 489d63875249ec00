#include "formats/ucsd_picture_copies.hpp"

#include <unistd.h>

#include <system_error>
#include <utility>

#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw DataError({folder.string()}, "the folder can't be made: " + error.message());
}

}  // namespace

UcsdPictureCopies::UcsdPictureCopies(fs::path folder, std::string prefix)
    : folder_(std::move(folder)),
      waiting_folder_(folder_.parent_path() / ("." + folder_.filename().string() + "." +
                                               std::to_string(::getpid()) + ".partial")),
      prefix_(std::move(prefix)) {}

UcsdPictureCopies::~UcsdPictureCopies() {
  std::error_code ignored;
  if (waiting_.empty()) return;
  fs::remove_all(waiting_folder_, ignored);
  fs::remove(folder_.parent_path(), ignored);  // only when nothing else is in it
}

void UcsdPictureCopies::add(const std::string& picture) {
  const fs::path source(picture);
  const std::string name = prefix_ + std::to_string(++count_) + source.extension().string();
  std::error_code error;
  if (fs::equivalent(source, folder_ / name, error)) return;
  if (waiting_.empty()) make_folder(waiting_folder_);
  waiting_.push_back(name);
  fs::copy_file(source, waiting_folder_ / name, fs::copy_options::overwrite_existing, error);
  if (error) throw DataError({picture}, "this picture can't be copied: " + error.message());
}

void UcsdPictureCopies::finish() {
  if (waiting_.empty()) return;
  make_folder(folder_);
  for (const std::string& name : waiting_) {
    std::error_code error;
    fs::rename(waiting_folder_ / name, folder_ / name, error);
    if (error) {
      throw DataError({(folder_ / name).string()},
                      "the picture can't be put in place: " + error.message());
    }
  }
  std::error_code ignored;
  fs::remove(waiting_folder_, ignored);
  waiting_.clear();
}

}  // namespace loopstone
