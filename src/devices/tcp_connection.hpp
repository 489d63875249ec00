#pragma once

#include <unistd.h>

#include <functional>
#include <string>
#include <utility>

namespace loopstone {

/// An open file, socket or port, which is closed in the end.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    close();
    number_ = std::exchange(other.number_, -1);
    return *this;
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int number() const { return number_; }
  [[nodiscard]] bool is_open() const { return number_ >= 0; }

 private:
  void close() const {
    if (is_open()) ::close(number_);
  }

  int number_ = -1;
};

/// What came of an attempt to connect.
struct TcpConnection {
  Descriptor socket{};         ///< open when it stands; it never blocks
  int error = 0;               ///< errno of the last place that was tried
  bool had_socket = false;     ///< whether this machine had one to try with
  std::string unknown_host{};  ///< why the name is no host's; empty: it is one
};

/// Tries the places of a host, one after the other.
/// \param host  a name or an address; of IPv6 without brackets
/// \param wait  until the descriptor can be written to; false when it took too long. What it throws
///              comes out
[[nodiscard]] TcpConnection try_tcp(const std::string& host, const std::string& port,
                                    const std::function<bool(int)>& wait);

}  // namespace loopstone
