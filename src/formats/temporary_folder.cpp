#include "formats/temporary_folder.hpp"

#include <cerrno>
#include <cstdlib>
#include <system_error>

#include "loopstone/base/error.hpp"

namespace loopstone {

namespace fs = std::filesystem;

TemporaryFolder::TemporaryFolder() {
  std::error_code error;
  const fs::path base = fs::temp_directory_path(error);
  std::string name = (base / "loopstone-XXXXXX").string();
  if (error || ::mkdtemp(name.data()) == nullptr) {
    const std::string why = error ? error.message() : std::generic_category().message(errno);
    throw DataError({name}, "no folder for temporary files can be made: " + why +
                                " (TMPDIR names another place)");
  }
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() { remove(); }

std::string TemporaryFolder::operator/(const std::string& name) const {
  return (path_ / name).string();
}

std::uintmax_t TemporaryFolder::free_bytes() const {
  std::error_code error;
  const auto space = fs::space(path_, error);
  return error ? 0 : space.available;
}

void TemporaryFolder::remove() noexcept {
  if (path_.empty()) return;
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  path_.clear();
}

}  // namespace loopstone
