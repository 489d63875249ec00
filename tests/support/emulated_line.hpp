#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace loopstone::test {

/// The device's end of a wire: a TCP port of this machine with one connection at a time, or a
/// pseudo terminal under a name that stays.
class EmulatedLine {
 public:
  enum class Kind { kTcp, kTerminal };
  /// \param port  of TCP; 0: any that is free
  explicit EmulatedLine(Kind kind, std::uint16_t port = 0);
  ~EmulatedLine();
  EmulatedLine(const EmulatedLine&) = delete;
  EmulatedLine& operator=(const EmulatedLine&) = delete;

  /// "127.0.0.1:40123", or the path of the terminal: what follows "scip://".
  [[nodiscard]] const std::string& place() const { return place_; }
  /// What has come, after waiting for so long at most; takes whoever wants to connect.
  [[nodiscard]] std::string read(int patience_ms);
  /// As a device does: what nobody takes is lost.
  void write(std::string_view bytes);
  /// Cuts the connection; a terminal is another one from then on, under the same name.
  void disconnect();

 private:
  void listen(std::uint16_t port);
  void open_terminal();

  Kind kind_;
  std::string place_{};
  std::string folder_{};  ///< of the terminal's name
  int listener_ = -1;
  int peer_ = -1;    ///< the connection, or the terminal's master
  int keeper_ = -1;  ///< holds the terminal open while nobody else does
};

}  // namespace loopstone::test
