#include "loopstone/live/view_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "loopstone/base/error.hpp"
#include "support/web_client.hpp"

namespace loopstone {
namespace {

using Json = nlohmann::json;
using test::WebClient;
using testing::HasSubstr;
using testing::Not;

/// A minute at most.
void wait_until(const std::function<bool()>& is_so) {
  for (int i = 0; i < 30'000 && !is_so(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  ASSERT_TRUE(is_so());
}

/// Until there is one of that op; its JSON.
Json next_op(WebClient& client, const std::string& op) {
  while (const auto message = client.receive()) {
    if (!message->is_text) continue;
    Json json = Json::parse(message->bytes);
    if (json["op"] == op) return json;
  }
  throw std::runtime_error("the server closed before it said " + op);
}

/// The payload of the next message.
std::string next_payload(WebClient& client) {
  while (const auto message = client.receive()) {
    if (!message->is_text && message->bytes.front() == 1) return message->bytes.substr(13);
  }
  throw std::runtime_error("the server closed before the next message");
}

class Server : public testing::Test {
 protected:
  ViewServerOptions options_{.name = "test", .port = 0};
};

TEST_F(Server, GivesThePageToWhoAsks) {
  ViewServer server(options_);
  server.start();
  EXPECT_EQ(server.url(), "http://127.0.0.1:" + std::to_string(server.port()) + "/");
  WebClient client(server.port());
  const auto page = client.get("/");
  EXPECT_EQ(page.status, 200);
  EXPECT_THAT(page.body, HasSubstr("<html"));
  EXPECT_THAT(page.head, HasSubstr("Content-Type: text/html"));
  EXPECT_THAT(page.head, HasSubstr("X-Content-Type-Options: nosniff"));
  EXPECT_THAT(page.head, HasSubstr("default-src 'none'"));
  EXPECT_THAT(page.head, HasSubstr("ws://127.0.0.1"));
  EXPECT_THAT(page.head, HasSubstr("frame-ancestors 'none'"));
  // On the same connection.
  const auto head = client.get("/", {}, "HEAD");
  EXPECT_EQ(head.status, 200);
  EXPECT_THAT(head.head, HasSubstr("Content-Length: " + std::to_string(page.body.size())));
  EXPECT_EQ(client.get("/no/such/page").status, 404);
  const auto post = client.get("/", "Content-Length: 0\r\n", "POST");
  EXPECT_EQ(post.status, 405);
  EXPECT_THAT(post.head, HasSubstr("Allow: GET, HEAD"));
}

TEST_F(Server, AsksTheProgramForTheRest) {
  ViewServer server(options_);
  server.on_get([](std::string_view path) -> std::optional<HttpAnswer> {
    if (path == "/api/about") return HttpAnswer{.body = R"({"mode":"replay"})"};
    if (path == "/api/fails") throw std::runtime_error("out of order");
    return {};
  });
  server.start();
  WebClient client(server.port());
  const auto about = client.get("/api/about?x=1");
  EXPECT_EQ(about.body, R"({"mode":"replay"})");
  EXPECT_THAT(about.head, HasSubstr("Content-Type: application/json"));
  EXPECT_THAT(about.head, HasSubstr("Cache-Control: no-store"));
  EXPECT_EQ(client.get("/api/closures/9").status, 404);
  const auto failed = client.get("/api/fails");
  EXPECT_EQ(failed.status, 500);
  EXPECT_EQ(Json::parse(failed.body)["error"], "out of order");
}

TEST_F(Server, TakesWhatIsPostedByThePageAndNobodyElse) {
  options_.token = "12345678";
  ViewServer server(options_);
  std::vector<std::string> posted;
  server.on_post([&](std::string_view path, std::string_view body) -> std::optional<HttpAnswer> {
    if (path != "/api/edits") return {};
    posted.emplace_back(body);
    return HttpAnswer{.body = R"({"done":true})"};
  });
  server.start();
  const std::string here = "/api/edits?token=12345678";
  WebClient client(server.port());
  EXPECT_EQ(client.post(here, "{\"a\":1}").body, R"({"done":true})");
  EXPECT_EQ(client.post(here, "{}", "Origin: http://127.0.0.1:1\r\n").status, 200);
  EXPECT_EQ(client.post("/api/edits", "{}").status, 401) << "without the token";
  EXPECT_EQ(client.post(here, "{}", "Origin: http://evil.example\r\n").status, 403);
  EXPECT_EQ(client.post(here, "{}", {}, "text/plain").status, 415)
      << "what a page of another host may send unasked";
  EXPECT_EQ(client.post("/api/other?token=12345678", "{}").status, 404);
  EXPECT_EQ(client.post("/?token=12345678", "{}").status, 405);
  EXPECT_EQ(posted, (std::vector<std::string>{"{\"a\":1}", "{}"}));
}

TEST_F(Server, BadRequestsAreRefused) {
  ViewServer server(options_);
  server.start();
  const auto status_of = [&](const std::string& request) {
    WebClient client(server.port());
    client.write(request);
    return client.read_response().status;
  };
  EXPECT_EQ(status_of("nonsense\r\n\r\n"), 400);
  EXPECT_EQ(status_of("GET / HTTP/7.5\r\n\r\n"), 400);
  EXPECT_EQ(status_of("GET /%zz HTTP/1.1\r\nHost: localhost\r\n\r\n"), 400);
  EXPECT_EQ(status_of("GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n"), 403);
  EXPECT_EQ(status_of("GET / HTTP/1.1\r\nX: " + std::string(40'000, 'x')), 431);
  EXPECT_EQ(status_of("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999\r\n\r\n"),
            413);
  EXPECT_EQ(status_of(std::string("\0\0\0\0\r\n\r\n", 8)), 400);
  WebClient alive(server.port());
  EXPECT_EQ(alive.get("/").status, 200);
}

TEST_F(Server, ShakesHandsAsTheStandardSays) {
  ViewServer server(options_);
  server.start();
  WebClient client(server.port());
  const auto response = client.open_socket("/any/path", {}, "x, foxglove.sdk.v1");
  EXPECT_EQ(response.status, 101);
  // RFC 6455, section 1.3.
  EXPECT_THAT(response.head, HasSubstr("Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo="));
  EXPECT_THAT(response.head, HasSubstr("Sec-WebSocket-Protocol: foxglove.sdk.v1"));
  EXPECT_THAT(response.head, Not(HasSubstr("permessage-deflate")));
  EXPECT_EQ(next_op(client, "serverInfo")["name"], "test");
}

TEST_F(Server, SocketsNeedTheRightProtocolOriginAndToken) {
  options_.token = "correct horse";
  options_.origins = {"https://app.foxglove.dev"};
  ViewServer server(options_);
  server.start();
  EXPECT_THAT(server.url(), HasSubstr("/?token=correct%20horse"));
  const auto status_of = [&](const char* target, const char* heads, const char* protocols) {
    WebClient client(server.port());
    return client.open_socket(target, heads, protocols).status;
  };
  const char* good = "/?token=correct%20horse";
  const char* spoken = "foxglove.websocket.v1";
  EXPECT_EQ(status_of(good, "", spoken), 101);
  EXPECT_EQ(status_of(good, "Origin: https://app.foxglove.dev\r\n", spoken), 101);
  EXPECT_EQ(status_of(good, "Origin: http://127.0.0.1\r\n", spoken), 101);
  EXPECT_EQ(status_of(good, "Host: robot:1\r\nOrigin: http://robot:1\r\n", spoken), 101);
  EXPECT_EQ(status_of(good, "Origin: https://evil.example\r\n", spoken), 403);
  EXPECT_EQ(status_of("/", "", spoken), 401);
  EXPECT_EQ(status_of("/?token=wrong", "", spoken), 401);
  EXPECT_EQ(status_of(good, "", ""), 400);
  EXPECT_EQ(status_of(good, "", "mqtt"), 400);
  WebClient client(server.port());
  EXPECT_EQ(client.get("/").status, 401);
  EXPECT_EQ(client.get(good).status, 200);
  EXPECT_EQ(client.get("/api/about?token=wrong").status, 401);
}

TEST_F(Server, SendsWhatIsSubscribedTo) {
  ViewServer server(options_);
  const ChannelId scans = server.add_channel({.topic = "/scan", .policy = SendPolicy::kEvery});
  const ChannelId map = server.add_channel({.topic = "/map", .policy = SendPolicy::kLatest});
  server.publish(map, Stamp{1}, "the map");
  server.start();
  WebClient client(server.port());
  ASSERT_EQ(client.open_socket().status, 101);
  EXPECT_EQ(next_op(client, "advertise")["channels"][1]["topic"], "/map");
  client.send_text(
      R"({"op":"subscribe","subscriptions":[{"id":5,"channelId":0},{"id":6,"channelId":1}]})");
  EXPECT_EQ(next_payload(client), "the map");
  server.publish(scans, Stamp{2}, std::string("\0scan", 5));
  EXPECT_EQ(next_payload(client), std::string("\0scan", 5));
  const std::string large(3'000'000, 'x');
  server.publish(scans, Stamp{3}, large);
  EXPECT_EQ(next_payload(client), large);
  EXPECT_EQ(server.clients(), 1U);
}

TEST_F(Server, ASlowClientHoldsUpNobody) {
  ViewServer server(options_);
  const ChannelId scans = server.add_channel({.topic = "/scan", .policy = SendPolicy::kDroppable});
  const ChannelId graph = server.add_channel({.topic = "/graph", .policy = SendPolicy::kLatest});
  server.start();
  constexpr int kSmall = 4096;
  WebClient slow(server.port(), kSmall);
  WebClient fast(server.port());
  for (WebClient* client : {&slow, &fast}) {
    ASSERT_EQ(client->open_socket().status, 101);
    client->send_text(
        R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":0},{"id":1,"channelId":1}]})");
    client->send_text(R"({"op":"dance"})");
    EXPECT_EQ(next_op(*client, "status")["level"], 2);  // it has subscribed by now
  }
  constexpr int kScans = 2000;
  for (int i = 0; i < kScans; ++i) {
    server.publish(scans, Stamp{i}, std::string(10'000, 's'));
    server.publish(graph, Stamp{i}, "graph " + std::to_string(i));
  }
  const auto scans_until_last = [&](WebClient& client) {
    for (int count = 0;; ++count) {
      if (next_payload(client) == "graph " + std::to_string(kScans - 1)) return count;
    }
  };
  (void)scans_until_last(fast);
  EXPECT_LT(scans_until_last(slow), kScans);
}

TEST_F(Server, WhoIsTooSlowForWhatItMustGetIsLetGo) {
  ViewServer server(options_, {.waiting_bytes = 1'000'000});
  const ChannelId all = server.add_channel({.topic = "/all", .policy = SendPolicy::kEvery});
  server.start();
  auto client = std::make_unique<WebClient>(server.port(), 1 << 16);
  WebClient& slow = *client;
  ASSERT_EQ(slow.open_socket().status, 101);
  slow.send_text(R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":0}]})");
  slow.send_text(R"({"op":"dance"})");
  (void)next_op(slow, "status");
  for (int i = 0; i < 1000; ++i) server.publish(all, Stamp{i}, std::string(10'000, 'x'));
  while (slow.receive()) {
  }
  EXPECT_EQ(slow.close_code(), 1008);
  client.reset();
  wait_until([&] { return server.clients() == 0; });
}

TEST_F(Server, HostileClientsHurtThemselvesOnly) {
  ViewServer server(options_,
                    {.clients = 4, .message_bytes = 1000, .handshake_s = 0.3, .idle_s = 4.0});
  const ChannelId scans = server.add_channel({.topic = "/scan", .policy = SendPolicy::kEvery});
  server.start();
  WebClient good(server.port());
  ASSERT_EQ(good.open_socket().status, 101);
  good.send_text(R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":0}]})");

  WebClient giant(server.port());
  ASSERT_EQ(giant.open_socket().status, 101);
  giant.send_text(std::string(1001, ' '));
  while (giant.receive()) {
  }
  EXPECT_EQ(giant.close_code(), 1009);

  WebClient endless(server.port());  // says that 2^62 bytes will come
  ASSERT_EQ(endless.open_socket().status, 101);
  endless.write(std::string("\x82\xff\x3f\xff\xff\xff\xff\xff\xff\xff....", 14));
  EXPECT_TRUE(endless.is_closed_by_server());

  WebClient unmasked(server.port());
  ASSERT_EQ(unmasked.open_socket().status, 101);
  unmasked.write(std::string("\x81\x02hi", 4));
  EXPECT_TRUE(unmasked.is_closed_by_server());

  WebClient no_text(server.port());
  ASSERT_EQ(no_text.open_socket().status, 101);
  no_text.send_text("\xff\xfe");
  EXPECT_TRUE(no_text.is_closed_by_server());

  WebClient half_open(server.port());  // never says what it wants
  WebClient half_said(server.port());
  half_said.write("GET / HTTP/1.1\r\nHost: loc");
  EXPECT_TRUE(half_open.is_closed_by_server());
  EXPECT_TRUE(half_said.is_closed_by_server());

  for (int i = 0; i < 20; ++i) {  // comes and goes
    WebClient gone(server.port());
    gone.write("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  }
  wait_until([&] { return server.clients() == 1; });
  server.publish(scans, Stamp{1}, "still here");
  EXPECT_EQ(next_payload(good), "still here");
}

TEST_F(Server, WhoAnswersNoPingIsGone) {
  ViewServer server(options_, {.idle_s = 0.4});
  server.start();
  WebClient dead(server.port());
  ASSERT_EQ(dead.open_socket().status, 101);
  wait_until([&] { return server.clients() == 1; });
  wait_until([&] { return server.clients() == 0; });
}

TEST_F(Server, ClientsAreLimited) {
  ViewServer server(options_, {.clients = 1, .connections = 3});
  server.start();
  WebClient first(server.port());
  ASSERT_EQ(first.open_socket().status, 101);
  (void)next_op(first, "serverInfo");
  WebClient second(server.port());
  ASSERT_EQ(second.open_socket().status, 101);
  while (second.receive()) {
  }
  EXPECT_EQ(second.close_code(), 1013);
  WebClient third(server.port());
  EXPECT_EQ(third.get("/").status, 200);
}

TEST_F(Server, PlaybackReachesTheProgram) {
  options_.range = PlaybackRange{Stamp{0}, Stamp{10}};
  ViewServer server(options_);
  std::atomic<int> asked{0};
  server.on_playback([&](const PlaybackControl& control) {
    if (control.request == "r" && !control.play) ++asked;
    server.set_playback({.status = PlaybackStatus::kPaused, .request = control.request});
  });
  server.start();
  WebClient client(server.port());
  ASSERT_EQ(client.open_socket().status, 101);
  client.send_bytes(std::string("\x03\x01\0\0\x80\x3f\0\0\0\0\0\0\0\0\0\x01\0\0\0r", 20));
  while (const auto message = client.receive()) {
    if (message->is_text || message->bytes.front() != 5) continue;
    EXPECT_EQ(message->bytes.size(), 20U);
    EXPECT_EQ(message->bytes.back(), 'r');
    break;
  }
  EXPECT_EQ(asked, 1);
}

TEST_F(Server, SaysWhatIsWrongWithItsOptions) {
  const auto reason_of = [](const std::function<void()>& action) -> std::string {
    try {
      action();
    } catch (const UsageError& error) {
      return error.what();
    }
    return "nothing";
  };
  EXPECT_THAT(reason_of([] { ViewServer({.address = "0.0.0.0", .port = 0}); }),
              HasSubstr("token is needed"));
  EXPECT_THAT(reason_of([] { ViewServer({.address = "::", .port = 0}); }),
              HasSubstr("token is needed"));
  EXPECT_THAT(reason_of([] { ViewServer({.address = "nowhere", .port = 0}); }),
              HasSubstr("no address"));
  EXPECT_THAT(reason_of([] { ViewServer({.token = "short"}); }), HasSubstr("8 characters"));
  ViewServer server(options_);
  server.start();
  EXPECT_THAT(reason_of([&] {
                ViewServer other({.port = server.port()});
                other.start();
              }),
              HasSubstr("port " + std::to_string(server.port()) + " of 127.0.0.1 is taken"));
  // Reachable by others: with a token it is.
  ViewServer open({.address = "0.0.0.0", .port = 0, .token = "12345678"});
  open.start();
  EXPECT_THAT(open.url(), HasSubstr("http://127.0.0.1:"));
  EXPECT_EQ(WebClient(open.port()).get("/?token=12345678").status, 200);
}

TEST_F(Server, EndsWhateverClientsDo) {
  auto server = std::make_unique<ViewServer>(options_);
  const ChannelId scans = server->add_channel({.topic = "/scan", .policy = SendPolicy::kEvery});
  server->start();
  WebClient polite(server->port());
  ASSERT_EQ(polite.open_socket().status, 101);
  (void)next_op(polite, "advertise");
  WebClient silent(server->port());
  WebClient stalled(server->port(), 4096);
  ASSERT_EQ(stalled.open_socket().status, 101);
  stalled.send_text(R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":0}]})");
  stalled.send_text(R"({"op":"dance"})");
  (void)next_op(stalled, "status");
  server->publish(scans, Stamp{1}, std::string(5'000'000, 'x'));
  server.reset();
  EXPECT_FALSE(polite.receive().has_value());
  EXPECT_EQ(polite.close_code(), 1001);
  EXPECT_TRUE(silent.is_closed_by_server());
  EXPECT_THROW(WebClient(0), std::runtime_error);
}

TEST_F(Server, PublishersOnManyThreadsAreFine) {
  ViewServer server(options_);
  const ChannelId every = server.add_channel({.topic = "/every", .policy = SendPolicy::kEvery});
  server.start();
  WebClient client(server.port());
  ASSERT_EQ(client.open_socket().status, 101);
  client.send_text(R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":0}]})");
  client.send_text(R"({"op":"dance"})");
  (void)next_op(client, "status");
  constexpr int kThreads = 4;
  constexpr int kEach = 200;
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < kEach; ++i) {
        server.publish(every, Stamp{i}, "x");
        server.set_time(Stamp{i});
      }
    });
  }
  for (int i = 0; i < kThreads * kEach; ++i) EXPECT_EQ(next_payload(client), "x");
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace loopstone
