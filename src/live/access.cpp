#include "live/access.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace loopstone {
namespace {

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool same_word(std::string_view a, std::string_view b) {
  return std::ranges::equal(a, b, {}, lower, lower);
}

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

int value_of_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  const char small = lower(c);
  return small >= 'a' && small <= 'f' ? small - 'a' + 10 : -1;
}

std::optional<std::string> unescaped(std::string_view text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      plain += text[i];
      continue;
    }
    if (text.size() - i < 3) return {};
    const int high = value_of_digit(text[i + 1]);
    const int low = value_of_digit(text[i + 2]);
    if (high < 0 || low < 0) return {};
    plain += static_cast<char>(16 * high + low);
    i += 2;
  }
  return plain;
}

/// Without port; "[::1]" keeps its brackets.
std::string_view name_of(std::string_view host) {
  const auto bracket = host.find(']');
  const auto colon = host.find(':', bracket == std::string_view::npos ? 0 : bracket);
  return host.substr(0, colon);
}

/// "host:port" of "http://host:port".
std::string_view host_of(std::string_view origin) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (origin.size() > scheme.size() && same_word(origin.substr(0, scheme.size()), scheme))
      return origin.substr(scheme.size());
  }
  return {};
}

bool is_allowed_origin(const AccessRules& rules, const RequestHeads& request) {
  const std::string_view origin = *request.origin;
  const std::string_view host = host_of(origin);
  if (!host.empty() && (same_word(host, request.host) || is_loopback_host(host))) return true;
  return std::ranges::any_of(rules.origins,
                             [&](const auto& one) { return same_word(one, origin); });
}

}  // namespace

std::optional<RequestTarget> parse_target(std::string_view target) {
  if (!target.starts_with('/')) return {};
  target = target.substr(0, target.find('#'));
  const auto question = target.find('?');
  auto path = unescaped(target.substr(0, question));
  if (!path) return {};
  RequestTarget parsed{.path = std::move(*path)};
  std::string_view query =
      question == std::string_view::npos ? std::string_view{} : target.substr(question + 1);
  while (!query.empty()) {
    const auto end = std::min(query.find('&'), query.size());
    const std::string_view one = query.substr(0, end);
    query.remove_prefix(std::min(end + 1, query.size()));
    constexpr std::string_view kToken = "token=";
    if (!one.starts_with(kToken)) continue;
    auto token = unescaped(one.substr(kToken.size()));
    if (!token) return {};
    parsed.token = std::move(*token);
  }
  return parsed;
}

std::string in_query(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  constexpr std::string_view kPlain = "-._~";
  std::string escaped;
  for (const char c : text) {
    const char small = lower(c);
    if ((small >= 'a' && small <= 'z') || (c >= '0' && c <= '9') ||
        kPlain.find(c) != std::string_view::npos) {
      escaped += c;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    escaped += '%';
    escaped += kDigits[byte >> 4U];
    escaped += kDigits[byte & 15U];
  }
  return escaped;
}

bool same_secret(std::string_view a, std::string_view b) {
  // Every byte of the longer one is looked at, whatever was found before.
  std::size_t difference = a.size() ^ b.size();
  for (std::size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
    const unsigned x = i < a.size() ? static_cast<unsigned char>(a[i]) : 0U;
    const unsigned y = i < b.size() ? static_cast<unsigned char>(b[i]) : 0U;
    difference |= x ^ y;
  }
  return difference == 0;
}

bool is_loopback_host(std::string_view host) {
  const std::string_view name = name_of(host);
  if (same_word(name, "localhost") || name == "[::1]") return true;
  constexpr std::string_view kBelow = ".localhost";
  if (name.size() > kBelow.size() && same_word(name.substr(name.size() - kBelow.size()), kBelow))
    return true;
  // 127.0.0.1 in digits; a name may begin so, too.
  return name.starts_with("127.") && std::ranges::count(name, '.') == 3 &&
         name.find_first_not_of("0123456789.") == std::string_view::npos;
}

std::optional<Refusal> refuse(const AccessRules& rules, const RequestHeads& request) {
  if (!rules.token.empty() && !same_secret(rules.token, request.token))
    return Refusal{401, "the address must end with ?token= and the token of this server"};
  if (rules.token.empty() && !is_loopback_host(request.host))
    return Refusal{403, "without a token this server answers as localhost only"};
  if (request.origin && !is_allowed_origin(rules, request))
    return Refusal{403, "this server does not know the page that asks; see its list of origins"};
  return {};
}

std::optional<std::string> choose_sub_protocol(std::string_view offered) {
  constexpr std::array<std::string_view, 2> kSpoken{"foxglove.websocket.v1", "foxglove.sdk.v1"};
  while (!offered.empty()) {
    const auto end = std::min(offered.find(','), offered.size());
    const std::string_view one = trimmed(offered.substr(0, end));
    offered.remove_prefix(std::min(end + 1, offered.size()));
    if (std::ranges::find(kSpoken, one) != kSpoken.end()) return std::string(one);
  }
  return {};
}

}  // namespace loopstone
