#include "devices/wire.hpp"

#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/ioctl.h>
#include <sys/poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <utility>

#include "loopstone/devices/scanner.hpp"

namespace loopstone {
namespace {

/// How long nobody asks stop().
constexpr double kLookAfterS = 0.05;

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string words_of_open_error(int error) {
  if (error == EACCES)
    return "may not be opened; join the group that owns it (usually: sudo usermod -a -G dialout "
           "$USER) and log in again";
  if (error == ENOENT || error == ENXIO || error == ENODEV)
    return "is not there; is the scanner plugged in? (ls /dev/ttyACM* /dev/ttyUSB*)";
  if (error == EBUSY) return "is in use by another program; end that one";
  return std::string("can't be opened: ") + std::strerror(error);
}

std::string words_of_connect_error(int error) {
  if (error == ECONNREFUSED)
    return "refuses the connection; is the port right, and no other program connected?";
  if (error == EHOSTUNREACH || error == ENETUNREACH || error == ETIMEDOUT)
    return "can't be reached; is the scanner powered, and this machine's network set to its "
           "subnet?";
  return std::string("can't be connected to: ") + std::strerror(error);
}

}  // namespace

Wire::Wire(const DeviceAddress& address, std::function<bool()> stop, double patience_s)
    : address_(address), stop_(std::move(stop)), patience_s_(patience_s) {
  if (address_.is_serial()) {
    open_serial();
  } else {
    connect(patience_s);
  }
}

// Somebody else may hold the port open from before: then closing it does not end that it is ours
// alone.
Wire::~Wire() {
  if (address_.is_serial()) (void)::ioctl(descriptor_.number(), TIOCNXCL);
}

void Wire::fail(const std::string& reason) const { throw DeviceError(address_.text, reason); }

void Wire::open_serial() {
  descriptor_ =
      Descriptor(::open(address_.path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!descriptor_.is_open()) fail(words_of_open_error(errno));
  const int port = descriptor_.number();
  if (::ioctl(port, TIOCEXCL) != 0 || !make_raw_line(port, address_.baud)) {
    if (errno == ENOTTY) fail("is no serial port; name one (ls /dev/ttyACM* /dev/ttyUSB*)");
    fail("can't be set to " + std::to_string(address_.baud) + " baud: " + std::strerror(errno));
  }
}

void Wire::connect(double patience_s) {
  TcpConnection made = try_tcp(address_.host, std::to_string(address_.port),
                               [&](int socket) { return wait(socket, POLLOUT, patience_s); });
  if (!made.unknown_host.empty())
    fail("names no host: " + made.unknown_host + "; give its IP address");
  if (!made.had_socket) fail(std::string("no socket can be had: ") + std::strerror(made.error));
  if (made.error != 0) fail(words_of_connect_error(made.error));
  descriptor_ = std::move(made.socket);
  const int on = 1;  // commands are short, and wait for nothing
  ::setsockopt(descriptor_.number(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

bool Wire::wait(int descriptor, short events, double patience_s) const {
  const double end_s = now_s() + patience_s;
  for (;;) {
    if (stop_ && stop_()) throw StopAsked();
    const double left_s = std::max(0.0, end_s - now_s());
    pollfd wanted{descriptor, events, 0};
    const auto look_ms = static_cast<int>(std::ceil(std::min(left_s, kLookAfterS) * 1e3));
    const int ready = ::poll(&wanted, 1, look_ms);
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR)
      fail(std::string("can't be waited for: ") + std::strerror(errno));
    if (left_s <= 0.0) return false;
  }
}

std::string_view Wire::read(double patience_s) {
  const double end_s = now_s() + patience_s;
  for (;;) {
    if (!wait(descriptor_.number(), POLLIN, end_s - now_s())) return {};
    const ssize_t count = ::read(descriptor_.number(), bytes_.data(), bytes_.size());
    const int error = errno;
    if (count > 0) {
      heard_ = HostTime::now();
      return {bytes_.data(), static_cast<std::size_t>(count)};
    }
    if (count < 0 && (error == EAGAIN || error == EINTR)) continue;
    if (!address_.is_serial() && (count == 0 || error == ECONNRESET))
      fail("has closed the connection; was it switched off, or is another program connected?");
    fail("is gone; was it unplugged? open it again when it is back");
  }
}

void Wire::write(std::string_view bytes) {
  while (!bytes.empty()) {
    if (!wait(descriptor_.number(), POLLOUT, patience_s_))
      fail("takes no bytes; switch it off and on");
    const ssize_t count =
        address_.is_serial()
            ? ::write(descriptor_.number(), bytes.data(), bytes.size())
            : ::send(descriptor_.number(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (count >= 0) {
      bytes.remove_prefix(static_cast<std::size_t>(count));
    } else if (errno != EAGAIN && errno != EINTR) {
      fail(std::string("can't be written to: ") + std::strerror(errno) + "; is it still there?");
    }
  }
}

void Wire::set_dtr(bool on) const {
  const int line = TIOCM_DTR;
  if (address_.is_serial()) (void)::ioctl(descriptor_.number(), on ? TIOCMBIS : TIOCMBIC, &line);
}

double Wire::seconds_for(std::size_t bytes) const {
  constexpr double kBitsOfByte = 10.0;  // with start and stop bit
  return address_.is_serial() ? static_cast<double>(bytes) * kBitsOfByte / address_.baud : 0.0;
}

}  // namespace loopstone
