#include <string>
#include <string_view>

#include "loopstone/messages/message_codec.hpp"

namespace loopstone {
namespace {

/// What stands between two marks, or nothing.
std::string_view between(std::string_view text, std::size_t begin, std::size_t end) {
  return begin <= end ? text.substr(begin, end - begin) : std::string_view{};
}

}  // namespace

std::string canonical_type(std::string_view type) {
  constexpr std::string_view kDds = "::msg::dds_::";
  constexpr std::string_view kMsg = "/msg/";
  std::string result(type);
  if (const auto at = type.find(kDds); at != std::string_view::npos && type.ends_with('_')) {
    result = std::string(type.substr(0, at)) + "/" +
             std::string(between(type, at + kDds.size(), type.size() - 1));
  } else if (const auto middle = type.find(kMsg); middle != std::string_view::npos) {
    result =
        std::string(type.substr(0, middle)) + "/" + std::string(type.substr(middle + kMsg.size()));
  }
  return result == "tf/tfMessage" ? "tf2_msgs/TFMessage" : result;
}

std::string ros2_type(std::string_view canonical) {
  const auto slash = canonical.find('/');
  if (slash == std::string_view::npos) return std::string(canonical);
  return std::string(canonical.substr(0, slash)) + "/msg" + std::string(canonical.substr(slash));
}

}  // namespace loopstone
