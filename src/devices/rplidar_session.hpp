#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "devices/rplidar_bytes.hpp"
#include "devices/wire.hpp"
#include "loopstone/devices/scanner.hpp"

namespace loopstone {

/// A way in which an RPLIDAR measures and sends.
struct RplidarMode {
  std::string name{};
  int number = 0;
  RplidarAnswer answer{};
  double sample_s = 0.0;  ///< from one measurement to the next
  double range_max_m = 0.0;
};

/// A conversation with an RPLIDAR: requests and their answers, one after another.
class RplidarSession {
 public:
  RplidarSession(const DeviceAddress& address, const ScannerOptions& options);

  /// Ends whatever the device does, and what it has sent so far is forgotten.
  void quiet();
  /// Throws DeviceError.
  [[nodiscard]] RplidarInfo ask_info();
  /// A device that has stopped to protect itself is started anew, once. Throws DeviceError when
  /// that does not help.
  void make_healthy();
  /// Those of the device that are understood here.
  [[nodiscard]] std::vector<RplidarMode> ask_modes(const RplidarInfo& info);
  void start_motor(const RplidarInfo& info);
  /// \return what came of its stream so far
  /// Throws DeviceError.
  [[nodiscard]] std::string start(const RplidarMode& mode);
  /// Ends it all; does not throw.
  void rest() noexcept;

  Wire& wire() { return wire_; }
  [[nodiscard]] const Wire& wire() const { return wire_; }

 private:
  /// Nothing when it does not come; others of that type than the one with that beginning are passed
  /// over.
  [[nodiscard]] std::optional<std::string> ask(RplidarCommand command, std::string_view payload,
                                               RplidarAnswer type, std::size_t length, int tries,
                                               std::string_view beginning = {});
  [[nodiscard]] std::optional<std::uint64_t> ask_number(RplidarSetting setting, int mode,
                                                        int bytes);
  /// The data of a setting; of a mode when that is not negative.
  [[nodiscard]] std::optional<std::string> ask_setting(RplidarSetting setting, int mode);
  [[nodiscard]] std::vector<RplidarMode> ask_configured_modes();

  Wire wire_;
  double silence_s_;
  bool has_pwm_ = false;
};

}  // namespace loopstone
