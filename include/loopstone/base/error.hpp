#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace loopstone {

/// Where in a file something is: a 1-based line of a text file or a byte offset of a binary one.
struct Location {
  std::string path;
  std::optional<std::int64_t> line{};
  std::optional<std::int64_t> byte_offset{};
};

/// "path:12" or "path (byte 4096)" or "path".
[[nodiscard]] std::string to_string(const Location& location);

/// Bad data: what a file holds cannot be used. what() reads "path:12: reason".
/// The reason says what is wrong and, where it can, what to do. The program exits with 1.
class DataError : public std::runtime_error {
 public:
  DataError(Location location, const std::string& reason);

  [[nodiscard]] const Location& location() const { return location_; }

 private:
  Location location_;
};

/// Bad usage or options: the caller asked for something that makes no sense. The program exits with
/// 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Something in a file that was skipped, with the reason; what a reader hands to its problem
/// callback.
struct Problem {
  Location location;
  std::string reason;
};

}  // namespace loopstone
