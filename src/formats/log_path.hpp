#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace loopstone {

/// What a user calls a log, taken apart: "DIR#20" is set 20 of a folder.
struct LogPath {
  std::filesystem::path path{};
  std::optional<int> set{};
};

/// Cuts off "#20", unless a file has that very name. Throws UsageError when no number follows.
[[nodiscard]] LogPath split_set(const std::string& path);

/// "Hokuyo20.npz" -> 20.
[[nodiscard]] std::optional<int> set_in_name(const std::string& name);

}  // namespace loopstone
