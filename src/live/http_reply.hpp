#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "live/access.hpp"
#include "loopstone/live/view_server.hpp"

namespace loopstone {

/// What is asked, already read.
struct HttpQuestion {
  std::string method{};  ///< "GET"
  std::string target{};
  std::string host{};
  std::optional<std::string> origin{};
  std::string content_type{};
  std::string body{};
};

struct HttpReply {
  int status = 200;
  std::string type{};
  std::string_view body{};  ///< of `owned`, or there for ever
  std::shared_ptr<const std::string> owned{};
  std::string policy{};  ///< Content-Security-Policy
};

/// What the program answers below /api/; nothing: there is no such thing.
struct HttpHandlers {
  std::function<std::optional<HttpAnswer>(std::string_view path)> get{};
  /// Empty: nothing can be changed here.
  std::function<std::optional<HttpAnswer>(std::string_view path, std::string_view body)> post{};
};

/// {"error": reason}
[[nodiscard]] HttpReply error_reply(int status, std::string_view reason);
/// Of the page and of /api/.
[[nodiscard]] HttpReply reply_to(const HttpQuestion& question, const AccessRules& rules,
                                 const HttpHandlers& handlers);
/// Whether a WebSocket may be opened.
[[nodiscard]] std::optional<Refusal> refuse_socket(const HttpQuestion& question,
                                                   const AccessRules& rules);

}  // namespace loopstone
