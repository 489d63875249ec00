#include "loopstone/live/view_server.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/version.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <exception>
#include <random>
#include <set>
#include <thread>
#include <utility>

#include "live/access.hpp"
#include "live/http_reply.hpp"
#include "live/view_hub.hpp"
#include "loopstone/base/error.hpp"

// The one source that knows Boost: it takes long to compile. What is said and to whom is told by
// ViewHub and reply_to(); here bytes go in and out. All but the constructor, start() and the
// destructor runs on the server's own thread, so nothing here is locked.

namespace loopstone {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::system::error_code;
using Tcp = asio::ip::tcp;
using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kMostHead = 16U << 10U;
/// Kept short in the kernel, so that what a slow client sees is not seconds old.
constexpr int kSendBuffer = 256 << 10;
constexpr std::chrono::milliseconds kGoodbye{300};
constexpr std::chrono::milliseconds kGlance{5};
constexpr std::chrono::seconds kLinger{2};
constexpr std::chrono::milliseconds kBeforeNextTry{100};

Clock::duration as_duration(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

/// What was read is at fault, not the connection.
bool is_of_http(error_code error) {
  return error.category() == http::make_error_code(http::error::bad_method).category();
}

/// What all connections share.
struct Service {
  Service(const ViewServerOptions& view_options, const ViewServerLimits& view_limits,
          std::string session)
      : options(view_options),
        limits(view_limits),
        rules{.token = options.token, .origins = options.origins},
        hub(options, limits, std::move(session)) {}

  ViewServerOptions options;
  ViewServerLimits limits;
  AccessRules rules;
  ViewHub hub;
  HttpHandlers handlers{};
};

/// One connection, while it lives.
class Connection {
 public:
  Connection() = default;
  virtual ~Connection() = default;
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  /// The server ends.
  virtual void end() = 0;
};

/// Those that live. They take themselves out.
using Connections = std::set<Connection*>;

class Registered : public Connection {
 public:
  explicit Registered(Connections& all) : all_(all) { all_.insert(this); }
  ~Registered() override { all_.erase(this); }
  Registered(const Registered&) = delete;
  Registered& operator=(const Registered&) = delete;

 protected:
  [[nodiscard]] Connections& all() const { return all_; }

 private:
  Connections& all_;
};

/// A client that gets what it subscribed to.
class Socket final : public Registered, public std::enable_shared_from_this<Socket> {
 public:
  Socket(Service& service, Connections& all, beast::tcp_stream stream)
      : Registered(all), service_(service), socket_(std::move(stream)) {}
  ~Socket() override {
    if (client_) service_.hub.leave(*client_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  void accept(http::request<http::string_body> request, const std::string& sub_protocol) {
    beast::get_lowest_layer(socket_).expires_never();
    socket_.set_option(websocket::stream_base::timeout{as_duration(service_.limits.handshake_s),
                                                       as_duration(service_.limits.idle_s), true});
    socket_.set_option(
        websocket::stream_base::decorator([sub_protocol](websocket::response_type& response) {
          response.set(http::field::server, "loopstone");
          response.set(http::field::sec_websocket_protocol, sub_protocol);
        }));
    socket_.read_message_max(service_.limits.message_bytes);
    socket_.auto_fragment(false);
    request_ = std::move(request);
    socket_.async_accept(request_, [self = shared_from_this()](error_code error) {
      if (!error) self->join();
    });
  }

  void end() override {
    if (is_sending_) return beast::get_lowest_layer(socket_).close();
    close({websocket::close_code::going_away, "the server ends"});
  }

 private:
  void join() {
    // Others wake it, so that is all they do.
    const std::weak_ptr<Socket> weak = weak_from_this();
    client_ = service_.hub.join([weak, executor = socket_.get_executor(), awake = is_awake_] {
      if (awake->exchange(true)) return;
      asio::post(executor, [weak] {
        if (const auto self = weak.lock()) self->send();
      });
    });
    if (!client_) return close({websocket::close_code::try_again_later, "too many clients"});
    receive();
  }

  void receive() {
    socket_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
      // Whoever is gone is forgotten with the last handler.
      if (error) return self->leave();
      self->take();
      self->receive();
    });
  }

  void take() {
    const auto bytes = buffer_.cdata();
    const std::string_view message(static_cast<const char*>(bytes.data()), bytes.size());
    if (socket_.got_text()) {
      service_.hub.receive_text(*client_, message);
    } else {
      service_.hub.receive_bytes(*client_, message);
    }
    buffer_.consume(buffer_.size());
  }

  /// One message at a time, as long as there are some.
  void send() {
    *is_awake_ = false;
    if (is_sending_ || is_closing_ || !client_) return;
    auto frame = service_.hub.next_frame(*client_);
    if (service_.hub.is_overrun(*client_))
      return close({websocket::close_code::policy_error, "too slow for what it subscribed to"});
    if (!frame) return;
    frame_ = std::move(*frame);
    is_sending_ = true;
    socket_.binary(!frame_.is_text);
    const std::array<asio::const_buffer, 2> buffers{
        asio::buffer(frame_.head), frame_.body ? asio::buffer(*frame_.body) : asio::const_buffer{}};
    socket_.async_write(buffers, [self = shared_from_this()](error_code error, std::size_t) {
      self->is_sending_ = false;
      self->frame_ = {};
      if (error) return self->leave();
      self->send();
    });
  }

  void close(const websocket::close_reason& reason) {
    if (is_closing_) return;
    is_closing_ = true;
    socket_.async_close(reason, [self = shared_from_this()](error_code) {});
  }

  void leave() {
    is_closing_ = true;
    if (client_) service_.hub.leave(*std::exchange(client_, std::nullopt));
  }

  Service& service_;
  websocket::stream<beast::tcp_stream> socket_;
  http::request<http::string_body> request_{};
  beast::flat_buffer buffer_{};
  std::optional<ViewHub::Client> client_{};
  OutFrame frame_{};
  std::shared_ptr<std::atomic<bool>> is_awake_ = std::make_shared<std::atomic<bool>>(false);
  bool is_sending_ = false;
  bool is_closing_ = false;
};

/// A connection that asks for pages, and may become a Socket.
class Visitor final : public Registered, public std::enable_shared_from_this<Visitor> {
 public:
  Visitor(Service& service, Connections& all, Tcp::socket socket)
      : Registered(all), service_(service), stream_(std::move(socket)) {}

  void receive() {
    parser_.emplace();
    parser_->header_limit(kMostHead);
    parser_->body_limit(service_.limits.message_bytes);
    // For the whole request, however slowly it comes.
    stream_.expires_after(as_duration(service_.limits.handshake_s));
    http::async_read(
        stream_, buffer_, *parser_,
        [self = shared_from_this()](error_code error, std::size_t) { self->take(error); });
  }

  void end() override { stream_.close(); }

 private:
  void take(error_code error) {
    if (error == http::error::header_limit || error == http::error::buffer_overflow)
      return refuse(431, "the head of the request is too large");
    if (error == http::error::body_limit) return refuse(413, "the request is too large");
    // Whoever closed the connection, or took too long, is told nothing.
    const bool is_gone = error == http::error::end_of_stream || !is_of_http(error);
    if (error && is_gone) return;
    if (error) return refuse(400, "the request is no HTTP");
    const auto& request = parser_->get();
    if (websocket::is_upgrade(request)) return upgrade();
    is_last_ = !request.keep_alive();
    reply(reply_to(question(), service_.rules, service_.handlers));
  }

  [[nodiscard]] HttpQuestion question() const {
    const auto& request = parser_->get();
    const auto text = [](beast::string_view view) { return std::string(view.data(), view.size()); };
    HttpQuestion asked{.method = text(request.method_string()),
                       .target = text(request.target()),
                       .host = text(request[http::field::host])};
    if (request.count(http::field::origin) > 0) asked.origin = text(request[http::field::origin]);
    asked.content_type = text(request[http::field::content_type]);
    if (request.method() == http::verb::post) asked.body = request.body();
    return asked;
  }

  void upgrade() {
    if (const auto refusal = refuse_socket(question(), service_.rules))
      return refuse(refusal->status, refusal->reason);
    const auto offered = parser_->get()[http::field::sec_websocket_protocol];
    const auto chosen = choose_sub_protocol({offered.data(), offered.size()});
    if (!chosen)
      return refuse(400, "a WebSocket here speaks foxglove.websocket.v1 or foxglove.sdk.v1");
    std::make_shared<Socket>(service_, all(), std::move(stream_))
        ->accept(parser_->release(), *chosen);
  }

  void refuse(int status, std::string_view reason) {
    is_last_ = true;
    reply(error_reply(status, reason));
  }

  void reply(HttpReply reply) {
    reply_ = std::move(reply);
    response_ = {};
    response_.version(11);
    response_.result(static_cast<unsigned>(reply_.status));
    response_.set(http::field::server, "loopstone");
    response_.set(http::field::content_type, reply_.type);
    response_.set(http::field::cache_control, "no-store");
    response_.set("X-Content-Type-Options", "nosniff");
    response_.set("Referrer-Policy", "no-referrer");
    response_.set("Cross-Origin-Resource-Policy", "same-origin");
    response_.set("Content-Security-Policy", reply_.policy);
    if (reply_.status == 405) response_.set(http::field::allow, "GET, HEAD");
    response_.keep_alive(!is_last_);
    response_.content_length(reply_.body.size());
    const bool head_alone =
        parser_->is_header_done() && parser_->get().method() == http::verb::head;
    if (!head_alone) response_.body() = {reply_.body.data(), reply_.body.size()};
    stream_.expires_after(as_duration(service_.limits.idle_s));
    serializer_.emplace(response_);
    const auto sent = [self = shared_from_this()](error_code error, std::size_t) {
      if (!error) self->go_on();
    };
    if (head_alone) {
      http::async_write_header(stream_, *serializer_, sent);
    } else {
      http::async_write(stream_, *serializer_, sent);
    }
  }

  void go_on() {
    if (!is_last_) return receive();
    error_code ignored;
    stream_.socket().shutdown(Tcp::socket::shutdown_send, ignored);
    parser_.reset();
    drain(0);
  }

  /// A connection that is closed with something unread takes the reply with it.
  void drain(std::size_t done) {
    constexpr std::size_t kMostDrained = std::size_t{8} << 20U;
    if (done > kMostDrained) return;
    buffer_.clear();
    stream_.expires_after(kLinger);
    stream_.async_read_some(buffer_.prepare(kMostHead),
                            [self = shared_from_this(), done](error_code error, std::size_t count) {
                              if (!error) self->drain(done + count);
                            });
  }

  using Body = http::span_body<const char>;

  Service& service_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{kMostHead + (std::size_t{1} << 17U)};
  std::optional<http::request_parser<http::string_body>> parser_{};
  HttpReply reply_{};
  http::response<Body> response_{};
  std::optional<http::response_serializer<Body>> serializer_{};
  bool is_last_ = false;
};

asio::ip::address address_of(const std::string& text) {
  error_code error;
  auto address = asio::ip::make_address(text == "localhost" ? "127.0.0.1" : text, error);
  if (error) throw UsageError(text + " is no address of a machine, such as 127.0.0.1 or 0.0.0.0");
  return address;
}

void check(const ViewServerOptions& options) {
  constexpr std::size_t kShortestToken = 8;
  const auto address = address_of(options.address);
  if (!options.token.empty() && options.token.size() < kShortestToken)
    throw UsageError("the token must have 8 characters at least");
  if (!address.is_loopback() && options.token.empty()) {
    throw UsageError(options.address +
                     " can be reached by other machines: a token is needed, which whoever wants to "
                     "look must know");
  }
}

/// Another one for each server, so that clients see that it is not the one before.
std::string new_session() {
  std::random_device random;
  return std::to_string(random()) + "-" + std::to_string(random());
}

}  // namespace

class ViewServer::Impl {
 public:
  Impl(const ViewServerOptions& options, const ViewServerLimits& limits)
      : service(options, limits, new_session()) {}
  ~Impl() { stop(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void start() {
    listen();
    accept();
    thread_ = std::thread([this] { run(); });
  }

  void stop() {
    if (!thread_.joinable()) return;
    asio::post(io_, [this] { say_goodbye(); });
    thread_.join();
  }

  [[nodiscard]] Tcp::endpoint endpoint() const { return endpoint_; }

  Service service;

 private:
  void listen() {
    const Tcp::endpoint wanted(address_of(service.options.address), service.options.port);
    try {
      acceptor_.open(wanted.protocol());
      acceptor_.set_option(asio::socket_base::reuse_address(true));
      acceptor_.bind(wanted);
      acceptor_.listen();
      endpoint_ = acceptor_.local_endpoint();
    } catch (const boost::system::system_error& error) {
      const std::string port = std::to_string(service.options.port);
      if (error.code() == asio::error::address_in_use) {
        throw UsageError("port " + port + " of " + service.options.address +
                         " is taken by another program, maybe by another view: choose another "
                         "port, or 0 for any that is free");
      }
      throw UsageError("can't listen on port " + port + " of " + service.options.address + ": " +
                       error.code().message());
    }
  }

  void accept() {
    acceptor_.async_accept([this](error_code error, Tcp::socket socket) {
      if (is_ending_) return;
      if (error) return accept_later();
      if (connections_.size() < service.limits.connections) welcome(std::move(socket));
      accept();
    });
  }

  /// Out of descriptors, or of memory: others may end.
  void accept_later() {
    timer_.expires_after(kBeforeNextTry);
    timer_.async_wait([this](error_code) {
      if (!is_ending_) accept();
    });
  }

  void welcome(Tcp::socket socket) {
    error_code ignored;
    socket.set_option(Tcp::no_delay(true), ignored);
    socket.set_option(asio::socket_base::send_buffer_size(kSendBuffer), ignored);
    std::make_shared<Visitor>(service, connections_, std::move(socket))->receive();
  }

  void run() {
    while (true) {
      try {
        io_.run();
        return;
      } catch (const std::exception&) {
        // Of one connection, which is gone with it: out of memory.
      }
    }
  }

  void say_goodbye() {
    is_ending_ = true;
    error_code ignored;
    acceptor_.close(ignored);
    const Connections present = connections_;
    for (Connection* connection : present) {
      if (connections_.contains(connection)) connection->end();
    }
    wait_for_goodbyes(Clock::now() + kGoodbye);
  }

  void wait_for_goodbyes(Clock::time_point end) {
    if (connections_.empty() || Clock::now() > end) return io_.stop();
    timer_.expires_after(kGlance);
    timer_.async_wait([this, end](error_code) { wait_for_goodbyes(end); });
  }

  // Connections outlive no io_, whose handlers hold them.
  Connections connections_{};
  asio::io_context io_{1};
  Tcp::acceptor acceptor_{io_};
  asio::steady_timer timer_{io_};
  Tcp::endpoint endpoint_{};
  bool is_ending_ = false;
  std::thread thread_{};
};

ViewServer::ViewServer(const ViewServerOptions& options, const ViewServerLimits& limits) {
  check(options);
  impl_ = std::make_unique<Impl>(options, limits);
}
ViewServer::~ViewServer() = default;

void ViewServer::on_get(std::function<std::optional<HttpAnswer>(std::string_view path)> answer) {
  impl_->service.handlers.get = std::move(answer);
}
void ViewServer::on_post(
    std::function<std::optional<HttpAnswer>(std::string_view path, std::string_view body)> answer) {
  impl_->service.handlers.post = std::move(answer);
}
void ViewServer::on_playback(std::function<void(const PlaybackControl&)> handle) {
  impl_->service.hub.on_playback(std::move(handle));
}
ChannelId ViewServer::add_channel(ViewChannel channel) {
  return impl_->service.hub.add_channel(std::move(channel));
}
void ViewServer::publish(ChannelId channel, Stamp stamp, std::string bytes) {
  impl_->service.hub.publish(channel, stamp, std::move(bytes));
}
void ViewServer::set_time(Stamp now) { impl_->service.hub.set_time(now); }
void ViewServer::set_playback(const PlaybackState& state) {
  impl_->service.hub.set_playback(state);
}

void ViewServer::start() { impl_->start(); }
void ViewServer::stop() { impl_->stop(); }
std::uint16_t ViewServer::port() const { return impl_->endpoint().port(); }

std::string ViewServer::url() const {
  const auto address = impl_->endpoint().address();
  // The address of all of this machine's is nobody's: here it is reached by the loopback one.
  std::string host =
      address.is_unspecified() ? (address.is_v6() ? "::1" : "127.0.0.1") : address.to_string();
  if (address.is_v6()) host = "[" + host + "]";
  const std::string& token = impl_->service.options.token;
  return "http://" + host + ":" + std::to_string(port()) + "/" +
         (token.empty() ? "" : "?token=" + in_query(token));
}

std::size_t ViewServer::clients() const { return impl_->service.hub.clients(); }
std::size_t ViewServer::subscribers(ChannelId channel) const {
  return impl_->service.hub.subscribers(channel);
}

}  // namespace loopstone
