#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "devices/clock_mapping.hpp"
#include "devices/device_address.hpp"
#include "devices/scip_text.hpp"
#include "devices/wire.hpp"
#include "loopstone/devices/scanner.hpp"

namespace loopstone {

/// A conversation with a SCIP device: commands and their replies, one after another.
class ScipSession {
 public:
  ScipSession(const DeviceAddress& address, const ScannerOptions& options);

  /// Ends whatever the device does, and what it has sent so far is forgotten.
  void quiet();
  /// The reply to a command, asked again when it is damaged. Throws DeviceError when none comes.
  [[nodiscard]] ScipReply ask(const std::string& command);
  /// "KEY:value" of a reply to VV, PP or II. Throws DeviceError, also when the device refuses.
  [[nodiscard]] std::map<std::string, std::string> ask_facts(const std::string& command);
  /// What the device's clock says [ms, 24 bits] at which steady time; nothing when it can't tell.
  struct ClockReading {
    std::int64_t count_ms = 0;
    std::int64_t steady_ns = 0;
  };
  [[nodiscard]] std::optional<ClockReading> ask_clock();

  /// Throws DeviceError with what a status means.
  [[noreturn]] void refuse(const std::string& command, std::string_view status) const;

  Wire& wire() { return wire_; }
  [[nodiscard]] const Wire& wire() const { return wire_; }
  ScipReplies& replies() { return replies_; }

 private:
  /// The next whole reply that begins with an echo; nothing when it does not come in time.
  [[nodiscard]] std::optional<ScipReply> await(const std::string& echo, double patience_s);

  Wire wire_;
  ScipReplies replies_{};
  double silence_s_;
  bool heard_any_ = false;
};

}  // namespace loopstone
