#include "live/http_reply.hpp"

#include <fmt/format.h>

#include <exception>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "live/page.hpp"

namespace loopstone {
namespace {

constexpr std::string_view kApi = "/api/";

/// Script and style stand in the page; it talks to this server alone, and no other page holds it.
/// Not every browser counts WebSockets of the same host to 'self'.
std::string page_policy(std::string_view host) {
  std::string sockets;
  if (host.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                             "-._:[]") == std::string_view::npos)
    sockets = fmt::format(" ws://{0} wss://{0}", host);
  return "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src "
         "'self' "
         "data: blob:; font-src data:; worker-src blob:; connect-src 'self'" +
         sockets + "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
}

HttpReply reply_of(HttpAnswer answer) {
  auto owned = std::make_shared<const std::string>(std::move(answer.body));
  return {.status = answer.status,
          .type = std::move(answer.type),
          .body = *owned,
          .owned = owned,
          .policy = "default-src 'none'; frame-ancestors 'none'"};
}

RequestHeads heads_of(const HttpQuestion& question, std::string token) {
  return {.host = question.host, .origin = question.origin, .token = std::move(token)};
}

/// \param answer  what the program says; may throw
template <typename Answer>
HttpReply ask(const Answer& answer) {
  try {
    if (std::optional<HttpAnswer> said = answer()) return reply_of(std::move(*said));
  } catch (const std::exception& error) {
    return error_reply(500, error.what());
  }
  return error_reply(404, "there is no such thing here");
}

/// What changes something is asked for by JSON, which pages of other hosts can't send unasked.
HttpReply reply_to_post(const HttpQuestion& question, const std::string& path,
                        const HttpHandlers& handlers) {
  if (!handlers.post || !path.starts_with(kApi))
    return error_reply(405, "only GET and HEAD are answered here");
  if (!question.content_type.starts_with("application/json"))
    return error_reply(415, "what is posted here is application/json");
  return ask([&] { return handlers.post(path, question.body); });
}

}  // namespace

HttpReply error_reply(int status, std::string_view reason) {
  const nlohmann::json body = {{"error", reason}};
  return reply_of({.status = status,
                   .body = body.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)});
}

HttpReply reply_to(const HttpQuestion& question, const AccessRules& rules,
                   const HttpHandlers& handlers) {
  auto target = parse_target(question.target);
  if (!target) return error_reply(400, "the target of the request is damaged");
  if (const auto refusal = refuse(rules, heads_of(question, std::move(target->token))))
    return error_reply(refusal->status, refusal->reason);
  if (question.method == "POST") return reply_to_post(question, target->path, handlers);
  if (question.method != "GET" && question.method != "HEAD")
    return error_reply(405, "only GET and HEAD are answered here");
  if (target->path == "/" || target->path == "/index.html") {
    return {.type = "text/html; charset=utf-8",
            .body = view_page(),
            .policy = page_policy(question.host)};
  }
  if (target->path.starts_with(kApi)) {
    return ask([&] { return handlers.get ? handlers.get(target->path) : std::nullopt; });
  }
  return error_reply(404, "there is no such page; the view is at /");
}

std::optional<Refusal> refuse_socket(const HttpQuestion& question, const AccessRules& rules) {
  auto target = parse_target(question.target);
  if (!target) return Refusal{400, "the target of the request is damaged"};
  return refuse(rules, heads_of(question, std::move(target->token)));
}

}  // namespace loopstone
