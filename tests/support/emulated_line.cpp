#include "support/emulated_line.hpp"

#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <utility>

namespace loopstone::test {
namespace {

void close_and_forget(int& descriptor) {
  if (descriptor >= 0) ::close(descriptor);
  descriptor = -1;
}

}  // namespace

EmulatedLine::EmulatedLine(Kind kind, std::uint16_t port) : kind_(kind) {
  if (kind == Kind::kTcp) {
    listen(port);
    return;
  }
  std::string folder =
      (std::filesystem::temp_directory_path() / "loopstone-scanner-XXXXXX").string();
  if (::mkdtemp(folder.data()) == nullptr) throw std::runtime_error("no folder for a terminal");
  folder_ = folder;
  place_ = folder_ + "/port";
  open_terminal();
}

EmulatedLine::~EmulatedLine() {
  close_and_forget(keeper_);
  close_and_forget(peer_);
  close_and_forget(listener_);
  std::error_code ignored;
  if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
}

void EmulatedLine::listen(std::uint16_t port) {
  listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int on = 1;
  ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(listener_, 1) != 0)
    throw std::runtime_error("no port to listen on");
  socklen_t size = sizeof address;
  ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
  place_ = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
}

void EmulatedLine::open_terminal() {
  peer_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  std::array<char, 128> name{};
  if (peer_ < 0 || ::grantpt(peer_) != 0 || ::unlockpt(peer_) != 0 ||
      ::ptsname_r(peer_, name.data(), name.size()) != 0)
    throw std::runtime_error("no pseudo terminal");
  keeper_ = ::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  termios line{};
  ::tcgetattr(keeper_, &line);
  ::cfmakeraw(&line);
  ::tcsetattr(keeper_, TCSANOW, &line);
  // Whoever looks finds either the old one or the new one.
  std::filesystem::create_symlink(name.data(), place_ + ".new");
  std::filesystem::rename(place_ + ".new", place_);
}

std::string EmulatedLine::read(int patience_ms) {
  pollfd waiting{.fd = peer_ >= 0 ? peer_ : listener_, .events = POLLIN, .revents = 0};
  if (::poll(&waiting, 1, patience_ms) <= 0) return {};
  if (peer_ < 0) {
    peer_ = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    return {};
  }
  std::array<char, 4096> bytes{};
  const auto count = ::read(peer_, bytes.data(), bytes.size());
  if (count > 0) return {bytes.data(), static_cast<std::size_t>(count)};
  if (kind_ == Kind::kTcp) close_and_forget(peer_);
  return {};
}

/// What nobody takes is lost, as on a real line: after a while, so that a busy machine is no
/// trouble of the line, but at once if the other side says something.
void EmulatedLine::write(std::string_view bytes) {
  constexpr int kPatienceMs = 1000;
  while (!bytes.empty() && peer_ >= 0) {
    const auto count = kind_ == Kind::kTcp ? ::send(peer_, bytes.data(), bytes.size(), MSG_NOSIGNAL)
                                           : ::write(peer_, bytes.data(), bytes.size());
    if (count > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(count));
      continue;
    }
    if (errno != EAGAIN) return;
    pollfd waiting{.fd = peer_, .events = POLLOUT | POLLIN, .revents = 0};
    if (::poll(&waiting, 1, kPatienceMs) <= 0 || (waiting.revents & POLLOUT) == 0) return;
  }
}

void EmulatedLine::disconnect() {
  int old_peer = std::exchange(peer_, -1);
  int old_keeper = std::exchange(keeper_, -1);
  if (kind_ == Kind::kTerminal) open_terminal();
  close_and_forget(old_keeper);
  close_and_forget(old_peer);
}

}  // namespace loopstone::test
