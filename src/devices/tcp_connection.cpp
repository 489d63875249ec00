#include "devices/tcp_connection.hpp"

#include <netdb.h>
#include <sys/socket.h>

#include <cerrno>
#include <memory>

namespace loopstone {
namespace {

using AddressList = std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)>;

/// errno of what went wrong, or 0.
int connect_to(const addrinfo& place, const Descriptor& socket,
               const std::function<bool(int)>& wait) {
  int error = ::connect(socket.number(), place.ai_addr, place.ai_addrlen) == 0 ? 0 : errno;
  if (error != EINPROGRESS) return error;
  error = ETIMEDOUT;
  socklen_t size = sizeof error;
  if (wait(socket.number())) ::getsockopt(socket.number(), SOL_SOCKET, SO_ERROR, &error, &size);
  return error;
}

}  // namespace

TcpConnection try_tcp(const std::string& host, const std::string& port,
                      const std::function<bool(int)>& wait) {
  TcpConnection tried{.error = ETIMEDOUT};
  addrinfo wanted{};
  wanted.ai_family = AF_UNSPEC;
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int unknown = ::getaddrinfo(host.c_str(), port.c_str(), &wanted, &found);
  if (unknown != 0) {
    tried.unknown_host = ::gai_strerror(unknown);
    return tried;
  }
  const AddressList owner(found, &::freeaddrinfo);
  for (const addrinfo* place = found; place != nullptr; place = place->ai_next) {
    Descriptor socket(::socket(place->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    tried.had_socket = socket.is_open();
    tried.error = socket.is_open() ? connect_to(*place, socket, wait) : errno;
    if (tried.error != 0) continue;
    tried.socket = std::move(socket);
    return tried;
  }
  return tried;
}

}  // namespace loopstone
