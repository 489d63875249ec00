#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace loopstone::test {

/// A connection to a server on this machine, of sockets alone: an HTTP and WebSocket client that
/// shares no code with the server. It waits for a minute, then gives up: throws std::runtime_error.
class WebClient {
 public:
  explicit WebClient(std::uint16_t port);
  ~WebClient();
  WebClient(const WebClient&) = delete;
  WebClient& operator=(const WebClient&) = delete;

  /// The kernel keeps little of what comes. Before connecting.
  static constexpr int kUsual = 0;
  WebClient(std::uint16_t port, int receive_buffer);

  void write(std::string_view bytes) const;
  /// Until the other side closes; what came.
  [[nodiscard]] std::string read_to_end();
  /// True when the other side closed, or closes.
  [[nodiscard]] bool is_closed_by_server();

  struct Response {
    int status = 0;
    std::string head{};
    std::string body{};
  };
  /// One response; of a HEAD request without body.
  [[nodiscard]] Response read_response(bool head_alone = false);
  /// A request with Host: 127.0.0.1, and what else it is to have ("Origin: x\r\n").
  [[nodiscard]] Response get(std::string_view target, std::string_view heads = {},
                             std::string_view method = "GET");

  /// The same with a body of that type.
  [[nodiscard]] Response post(std::string_view target, std::string_view body,
                              std::string_view heads = {},
                              std::string_view type = "application/json");

  /// The response to an upgrade; 101 when it is a WebSocket from now on.
  [[nodiscard]] Response open_socket(std::string_view target = "/", std::string_view heads = {},
                                     std::string_view protocols = "foxglove.websocket.v1");
  void send_text(std::string_view text) const { send_frame(1, text); }
  void send_bytes(std::string_view bytes) const { send_frame(2, bytes); }
  /// Masked, whole.
  void send_frame(int opcode, std::string_view payload) const;

  struct Message {
    bool is_text = false;
    std::string bytes{};
  };
  /// The next one; pings are answered. Nothing when the server closed.
  [[nodiscard]] std::optional<Message> receive();
  /// Of the close frame that came.
  [[nodiscard]] int close_code() const { return close_code_; }

 private:
  /// False at the end.
  bool read_some();
  [[nodiscard]] bool fill(std::size_t count);

  int socket_ = -1;
  std::string buffer_{};
  int close_code_ = 0;
};

}  // namespace loopstone::test
