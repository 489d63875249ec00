#include "support/web_client.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <stdexcept>
#include <utility>

namespace loopstone::test {

namespace {
constexpr int kPatienceMs = 60'000;
}

WebClient::WebClient(std::uint16_t port) : WebClient(port, kUsual) {}

WebClient::WebClient(std::uint16_t port, int receive_buffer) {
  socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (receive_buffer > 0)
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0)
    throw std::runtime_error("nobody listens on port " + std::to_string(port));
}

WebClient::~WebClient() { ::close(socket_); }

void WebClient::write(std::string_view bytes) const {
  while (!bytes.empty()) {
    const auto sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) throw std::runtime_error("the connection was closed while something was sent");
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
}

bool WebClient::read_some() {
  pollfd waiting{.fd = socket_, .events = POLLIN};
  if (::poll(&waiting, 1, kPatienceMs) <= 0) throw std::runtime_error("nothing came");
  std::array<char, 65536> bytes{};
  const auto count = ::recv(socket_, bytes.data(), bytes.size(), 0);
  if (count <= 0) return false;
  buffer_.append(bytes.data(), static_cast<std::size_t>(count));
  return true;
}

bool WebClient::fill(std::size_t count) {
  while (buffer_.size() < count) {
    if (!read_some()) return false;
  }
  return true;
}

std::string WebClient::read_to_end() {
  while (read_some()) {
  }
  return std::exchange(buffer_, {});
}

bool WebClient::is_closed_by_server() {
  while (read_some()) buffer_.clear();
  return true;
}

WebClient::Response WebClient::read_response(bool head_alone) {
  std::size_t end = 0;
  while ((end = buffer_.find("\r\n\r\n")) == std::string::npos) {
    if (!read_some()) throw std::runtime_error("the connection was closed before a response");
  }
  Response response{.head = buffer_.substr(0, end + 2)};
  buffer_.erase(0, end + 4);
  response.status = std::atoi(response.head.substr(response.head.find(' ')).c_str());
  constexpr std::string_view kLength = "Content-Length: ";
  const auto length = response.head.find(kLength);
  if (head_alone || length == std::string::npos) return response;
  const auto count = static_cast<std::size_t>(
      std::strtoull(response.head.c_str() + length + kLength.size(), nullptr, 10));
  if (!fill(count)) throw std::runtime_error("the response was cut off");
  response.body = buffer_.substr(0, count);
  buffer_.erase(0, count);
  return response;
}

WebClient::Response WebClient::get(std::string_view target, std::string_view heads,
                                   std::string_view method) {
  std::string request = std::string(method) + " " + std::string(target) + " HTTP/1.1\r\n";
  if (heads.find("Host: ") == std::string_view::npos) request += "Host: 127.0.0.1\r\n";
  write(request + std::string(heads) + "\r\n");
  return read_response(method == "HEAD");
}

WebClient::Response WebClient::post(std::string_view target, std::string_view body,
                                    std::string_view heads, std::string_view type) {
  std::string request = "POST " + std::string(target) + " HTTP/1.1\r\n";
  if (heads.find("Host: ") == std::string_view::npos) request += "Host: 127.0.0.1\r\n";
  request += "Content-Type: " + std::string(type) +
             "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n" + std::string(heads) +
             "\r\n";
  write(request + std::string(body));
  return read_response();
}

WebClient::Response WebClient::open_socket(std::string_view target, std::string_view heads,
                                           std::string_view protocols) {
  std::string all = std::string(heads) +
                    "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
  if (!protocols.empty()) all += "Sec-WebSocket-Protocol: " + std::string(protocols) + "\r\n";
  return get(target, all);
}

void WebClient::send_frame(int opcode, std::string_view payload) const {
  std::string frame(1, static_cast<char>(0x80 | opcode));
  const auto length = payload.size();
  const auto append = [&](std::size_t bytes) {
    for (std::size_t i = bytes; i-- > 0;) frame += static_cast<char>((length >> (8 * i)) & 0xFFU);
  };
  if (length < 126) {
    frame += static_cast<char>(0x80 | length);
  } else if (length < 65536) {
    frame += static_cast<char>(0x80 | 126);
    append(2);
  } else {
    frame += static_cast<char>(0x80 | 127);
    append(8);
  }
  constexpr std::string_view kMask = "mask";
  frame += kMask;
  for (std::size_t i = 0; i < length; ++i)
    frame += static_cast<char>(payload[i] ^ kMask[i % kMask.size()]);
  write(frame);
}

std::optional<WebClient::Message> WebClient::receive() {
  Message message;
  while (true) {
    if (!fill(2)) return {};
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(buffer_[i]); };
    const bool is_last = (byte(0) & 0x80U) != 0;
    const int opcode = byte(0) & 0x0F;
    std::size_t length = byte(1) & 0x7FU;
    std::size_t head = 2;
    const std::size_t more = length == 126 ? 2 : length == 127 ? 8 : 0;
    if (more > 0) {
      if (!fill(head + more)) return {};
      length = 0;
      for (std::size_t i = 0; i < more; ++i) length = length << 8U | byte(head + i);
      head += more;
    }
    if (!fill(head + length)) return {};
    const std::string payload = buffer_.substr(head, length);
    buffer_.erase(0, head + length);
    if (opcode == 9) {
      send_frame(10, payload);
    } else if (opcode == 8) {
      if (payload.size() >= 2)
        close_code_ =
            static_cast<unsigned char>(payload[0]) * 256 + static_cast<unsigned char>(payload[1]);
      return {};
    } else if (opcode <= 2) {
      if (opcode != 0) message.is_text = opcode == 1;
      message.bytes += payload;
      if (is_last) return message;
    }
  }
}

}  // namespace loopstone::test
