#include "devices/wire.hpp"

#include <fcntl.h>
#include <netdb.h>
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
#include <memory>
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

using AddressList = std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)>;

}  // namespace

Wire::Wire(const DeviceAddress& address, std::function<bool()> stop, double patience_s)
    : address_(address), stop_(std::move(stop)), patience_s_(patience_s) {
  try {
    if (address_.is_serial()) {
      open_serial();
    } else {
      connect(patience_s);
    }
  } catch (...) {
    if (descriptor_ >= 0) ::close(descriptor_);
    throw;
  }
}

Wire::~Wire() { ::close(descriptor_); }

void Wire::fail(const std::string& reason) const { throw DeviceError(address_.text, reason); }

void Wire::open_serial() {
  descriptor_ = ::open(address_.path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor_ < 0) fail(words_of_open_error(errno));
  if (::ioctl(descriptor_, TIOCEXCL) != 0 || !make_raw_line(descriptor_, address_.baud)) {
    if (errno == ENOTTY) fail("is no serial port; name one (ls /dev/ttyACM* /dev/ttyUSB*)");
    fail("can't be set to " + std::to_string(address_.baud) + " baud: " + std::strerror(errno));
  }
}

void Wire::connect(double patience_s) {
  addrinfo wanted{};
  wanted.ai_family = AF_UNSPEC;
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int unknown =
      ::getaddrinfo(address_.host.c_str(), std::to_string(address_.port).c_str(), &wanted, &found);
  if (unknown != 0)
    fail(std::string("names no host: ") + ::gai_strerror(unknown) + "; give its IP address");
  const AddressList owner(found, &::freeaddrinfo);
  int error = ETIMEDOUT;
  for (const addrinfo* place = found; place != nullptr; place = place->ai_next) {
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = ::socket(place->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (descriptor_ < 0) fail(std::string("no socket can be had: ") + std::strerror(errno));
    error = ::connect(descriptor_, place->ai_addr, place->ai_addrlen) == 0 ? 0 : errno;
    if (error == EINPROGRESS) {
      socklen_t size = sizeof error;
      error = ETIMEDOUT;
      if (wait(POLLOUT, patience_s)) ::getsockopt(descriptor_, SOL_SOCKET, SO_ERROR, &error, &size);
    }
    if (error == 0) break;
  }
  if (error != 0) fail(words_of_connect_error(error));
  const int on = 1;  // commands are short, and wait for nothing
  ::setsockopt(descriptor_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

bool Wire::wait(short events, double patience_s) const {
  const double end_s = now_s() + patience_s;
  for (;;) {
    if (stop_ && stop_()) throw StopAsked();
    const double left_s = std::max(0.0, end_s - now_s());
    pollfd wanted{descriptor_, events, 0};
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
    if (!wait(POLLIN, end_s - now_s())) return {};
    const ssize_t count = ::read(descriptor_, bytes_.data(), bytes_.size());
    const int error = errno;
    if (count > 0) {
      heard_ = HostTime::now();
      return {bytes_.data(), static_cast<std::size_t>(count)};
    }
    if (count < 0 && (error == EAGAIN || error == EINTR)) continue;
    if (count == 0 && !address_.is_serial())
      fail("has closed the connection; was it switched off, or is another program connected?");
    fail("is gone; was it unplugged? open it again when it is back");
  }
}

void Wire::write(std::string_view bytes) {
  while (!bytes.empty()) {
    if (!wait(POLLOUT, patience_s_)) fail("takes no bytes; switch it off and on");
    const ssize_t count = address_.is_serial()
                              ? ::write(descriptor_, bytes.data(), bytes.size())
                              : ::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (count >= 0) {
      bytes.remove_prefix(static_cast<std::size_t>(count));
    } else if (errno != EAGAIN && errno != EINTR) {
      fail(std::string("can't be written to: ") + std::strerror(errno) + "; is it still there?");
    }
  }
}

void Wire::set_dtr(bool on) const {
  const int line = TIOCM_DTR;
  if (address_.is_serial()) (void)::ioctl(descriptor_, on ? TIOCMBIS : TIOCMBIC, &line);
}

double Wire::seconds_for(std::size_t bytes) const {
  constexpr double kBitsOfByte = 10.0;  // with start and stop bit
  return address_.is_serial() ? static_cast<double>(bytes) * kBitsOfByte / address_.baud : 0.0;
}

}  // namespace loopstone
