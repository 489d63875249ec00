#include "devices/scip_session.hpp"

#include <fmt/format.h>

#include <limits>

namespace loopstone {
namespace {

constexpr int kTries = 4;

std::string line_of(const std::string& command) { return command + "\n"; }

double seconds_since(std::int64_t steady_ns) {
  return static_cast<double>(HostTime::now().steady_ns - steady_ns) * 1e-9;
}

}  // namespace

ScipSession::ScipSession(const DeviceAddress& address, const ScannerOptions& options)
    : wire_(address, options.stop, options.silence_s), silence_s_(options.silence_s) {}

std::optional<ScipReply> ScipSession::await(const std::string& echo, double patience_s) {
  const std::int64_t began_ns = HostTime::now().steady_ns;
  for (double left_s = patience_s;;) {
    while (auto reply = replies_.next()) {
      // What the last user left in the device's buffer may stand before it.
      if (reply->echo.ends_with(echo)) return reply;
    }
    if (left_s <= 0.0) return {};
    left_s = patience_s - seconds_since(began_ns);
    const std::string_view bytes = wire_.read(left_s);
    heard_any_ = heard_any_ || !bytes.empty();
    replies_.add(bytes);
  }
}

// Scans that are on the way come first, and half a command may lie in the device's buffer: then
// the first QT becomes its end, and only the second is heard. A URG-04LX may still speak SCIP 1.1,
// until it is told "SCIP2.0".
void ScipSession::quiet() {
  for (int i = 0; i < kTries; ++i) {
    if (i == kTries / 2) wire_.write(line_of("SCIP2.0"));
    wire_.write(line_of("QT"));
    const auto reply = await("QT", silence_s_ / 2);
    if (reply && reply->echo == "QT" && !reply->status().empty()) {
      replies_ = {};
      return;
    }
  }
  wire_.fail(heard_any_ ? "sends, but does not understand SCIP; is it such a scanner, and the baud "
                          "rate right?"
                        : "is silent; is it powered, a SCIP scanner, and the baud rate right?");
}

ScipReply ScipSession::ask(const std::string& command) {
  for (int i = 0; i < kTries; ++i) {
    wire_.write(line_of(command));
    auto reply = await(command, silence_s_ / 2);
    if (reply && reply->echo == command && !reply->status().empty()) return *std::move(reply);
  }
  wire_.fail(command.substr(0, 2) +
             " gets no sound reply; is the line good, and the baud rate right?");
}

std::map<std::string, std::string> ScipSession::ask_facts(const std::string& command) {
  for (int i = 0; i < kTries; ++i) {
    const ScipReply reply = ask(command);
    if (reply.status() != "00") refuse(command, reply.status());
    if (auto facts = scip_facts(reply)) return *std::move(facts);
  }
  wire_.fail(command + " gets replies with wrong checksums; is the line good?");
}

std::optional<ScipSession::ClockReading> ScipSession::ask_clock() {
  constexpr int kReadings = 8;
  // 02: it is in that mode already.
  if (const ScipReply begun = ask("TM0"); begun.status() != "00" && begun.status() != "02")
    return {};
  std::optional<ClockReading> best;
  std::int64_t quickest_ns = std::numeric_limits<std::int64_t>::max();
  for (int i = 0; i < kReadings; ++i) {
    const std::int64_t asked_ns = HostTime::now().steady_ns;
    const ScipReply reply = ask("TM1");
    const auto text = reply.status() == "00" && reply.lines.size() == 2
                          ? checked_line(reply.lines[1])
                          : std::nullopt;
    const auto count = text && text->size() == 4 ? scip_number(*text) : std::nullopt;
    const std::int64_t took_ns = wire_.heard().steady_ns - asked_ns;
    if (!count || took_ns >= quickest_ns) continue;
    quickest_ns = took_ns;
    best = ClockReading{*count, asked_ns + took_ns / 2};
  }
  (void)ask("TM2");
  return best;
}

void ScipSession::refuse(const std::string& command, std::string_view status) const {
  wire_.fail(fmt::format("refuses {}: {}", command.substr(0, 2), words_of_status(command, status)));
}

}  // namespace loopstone
