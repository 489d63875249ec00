#include "loopstone/base/error.hpp"

#include "loopstone/base/short_text.hpp"

namespace loopstone {

std::string to_string(const Location& location) {
  std::string text = location.path;
  if (location.line) text += ":" + std::to_string(*location.line);
  if (location.byte_offset) text += " (byte " + std::to_string(*location.byte_offset) + ")";
  return text;
}

DataError::DataError(Location location, const std::string& reason)
    : std::runtime_error(to_string(location) + ": " + with_short_numbers(reason)),
      location_(std::move(location)) {}

}  // namespace loopstone
