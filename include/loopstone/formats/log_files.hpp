#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace loopstone {

/// The files that a log consists of (of a folder the sensors of one set; pictures are left out), as
/// they were when this was made. Empty when there is no such log; that is open_log()'s to say.
class LogFiles {
 public:
  LogFiles() = default;
  /// \param log  as open_log() takes it. Throws what open_log() throws for a folder without the set
  ///             that is asked for.
  explicit LogFiles(const std::string& log);

  [[nodiscard]] std::vector<std::string> paths() const;
  /// Of all together. Pipes have none.
  [[nodiscard]] std::int64_t bytes() const;
  /// One sentence for every file that is not what it was: shorter, longer, written to, gone.
  [[nodiscard]] std::vector<std::string> changes() const;

 private:
  struct File {
    std::string path;
    std::int64_t bytes = 0;
    std::filesystem::file_time_type written{};
    bool is_regular = false;
  };
  [[nodiscard]] static File look_at(const std::string& path);

  std::vector<File> files_{};
};

}  // namespace loopstone
