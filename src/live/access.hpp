#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

// Who may connect. Browsers let any page open a WebSocket to this machine, so a page's origin is
// asked for; and any name may be made to mean this machine, so the name that was called is, too.

namespace loopstone {

struct AccessRules {
  std::string token{};  ///< empty: none is asked for
  std::vector<std::string> origins{};
};

/// The target of a request, "/api/about?token=..".
struct RequestTarget {
  std::string path{};
  std::string token{};
};
/// With what stands for other characters (%41) put right; nothing for one that is damaged.
[[nodiscard]] std::optional<RequestTarget> parse_target(std::string_view target);
/// As it must be written in a query.
[[nodiscard]] std::string in_query(std::string_view text);

/// What a request says of who asks.
struct RequestHeads {
  std::string host{};                   ///< "localhost:8765"
  std::optional<std::string> origin{};  ///< "https://app.foxglove.dev"
  std::string token{};
};

struct Refusal {
  int status = 403;
  std::string reason{};
};
[[nodiscard]] std::optional<Refusal> refuse(const AccessRules& rules, const RequestHeads& request);

/// Takes as long wherever they differ.
[[nodiscard]] bool same_secret(std::string_view a, std::string_view b);
/// "localhost" and names below it, 127.x.y.z, [::1]; with or without a port.
[[nodiscard]] bool is_loopback_host(std::string_view host);
/// Of a comma-separated list of sub-protocols the first one that is spoken here.
[[nodiscard]] std::optional<std::string> choose_sub_protocol(std::string_view offered);

}  // namespace loopstone
