#include "formats/log_path.hpp"

#include <string_view>

#include "formats/text_numbers.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {

namespace fs = std::filesystem;

LogPath split_set(const std::string& path) {
  const std::size_t hash = path.rfind('#');
  std::error_code ignored;
  if (hash == path.npos || fs::exists(path, ignored)) return {path};
  const auto set = parse_integer(std::string_view(path).substr(hash + 1));
  if (!set || *set < 0 || *set > 1'000'000) {
    throw UsageError("'" + path + "': after '#' the number of a set was expected");
  }
  return {path.substr(0, hash), static_cast<int>(*set)};
}

std::optional<int> set_in_name(const std::string& name) {
  const std::size_t end = name.rfind('.');
  std::size_t begin = end;
  while (begin != name.npos && begin > 0 && name[begin - 1] >= '0' && name[begin - 1] <= '9') {
    --begin;
  }
  if (end == name.npos || begin == end) return std::nullopt;
  const auto set = parse_integer(std::string_view(name).substr(begin, end - begin));
  if (!set || *set > 1'000'000) return std::nullopt;
  return static_cast<int>(*set);
}

}  // namespace loopstone
