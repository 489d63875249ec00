#pragma once

#include <cstdint>
#include <string>

namespace loopstone {

enum class DeviceProtocol { kScip, kRplidar };

/// An address of a scanner in its pieces.
struct DeviceAddress {
  std::string text{};  ///< as it was given
  DeviceProtocol protocol{};
  std::string host{};  ///< empty: a serial port
  std::uint16_t port = 0;
  std::string path{};  ///< of the serial port
  int baud = 115200;
  std::string mode{};  ///< of an RPLIDAR; empty: its fastest

  [[nodiscard]] bool is_serial() const { return host.empty(); }
};

/// Throws UsageError that says how an address is written.
[[nodiscard]] DeviceAddress parse_device_address(const std::string& text);

}  // namespace loopstone
