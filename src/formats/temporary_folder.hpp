#pragma once

#include <filesystem>
#include <string>

namespace loopstone {

/// A folder of its own among the machine's temporary files, removed with all that is in it.
class TemporaryFolder {
 public:
  /// Throws DataError when it can't be made.
  TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();

  /// A name inside.
  [[nodiscard]] std::string operator/(const std::string& name) const;
  /// Bytes that are free there; 0 when that can't be told.
  [[nodiscard]] std::uintmax_t free_bytes() const;
  /// Before its end; files that are open stay readable.
  void remove() noexcept;

 private:
  std::filesystem::path path_;
};

}  // namespace loopstone
