#pragma once

#include <array>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "devices/clock_mapping.hpp"
#include "devices/device_address.hpp"
#include "devices/tcp_connection.hpp"

namespace loopstone {

/// Thrown by whoever waits when stop() says so; open_scanner and Scanner::next catch it.
struct StopAsked {};

/// The line to a device: a TCP connection, or a serial port that nobody else can open.
class Wire {
 public:
  /// \param patience_s  for a connection, and for a device that takes no bytes
  /// Throws DeviceError; StopAsked.
  Wire(const DeviceAddress& address, std::function<bool()> stop, double patience_s);
  ~Wire();
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;

  /// What has come, waiting for it up to patience_s: empty when nothing came. Good until the next
  /// call. What is there is read though patience has ended: whoever was held up himself asks once
  /// more before he gives up. Throws DeviceError when the device is gone; StopAsked.
  [[nodiscard]] std::string_view read(double patience_s);
  /// When the bytes of the last read were there.
  [[nodiscard]] const HostTime& heard() const { return heard_; }
  void write(std::string_view bytes);
  /// The line DTR of a serial port; nothing where there is none.
  void set_dtr(bool on) const;
  /// How long so many bytes are under way: none over a network, whose rate nobody knows.
  [[nodiscard]] double seconds_for(std::size_t bytes) const;

  [[nodiscard]] const DeviceAddress& address() const { return address_; }
  /// Throws DeviceError with this wire's address.
  [[noreturn]] void fail(const std::string& reason) const;

 private:
  void connect(double patience_s);
  void open_serial();
  /// False when patience ended first.
  [[nodiscard]] bool wait(int descriptor, short events, double patience_s) const;

  DeviceAddress address_;
  std::function<bool()> stop_;
  double patience_s_;
  Descriptor descriptor_{};
  HostTime heard_{};
  std::array<char, 65536> bytes_{};
};

/// Makes a terminal a plain line of bytes: raw, 8 bits, no parity, one stop bit, no flow control,
/// any rate. Returns false, with errno, when it is none or can't be so.
[[nodiscard]] bool make_raw_line(int descriptor, int baud);

}  // namespace loopstone
