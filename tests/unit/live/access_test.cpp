#include "live/access.hpp"

#include <gtest/gtest.h>

namespace loopstone {
namespace {

TEST(Access, ReadsTargets) {
  EXPECT_EQ(parse_target("/")->path, "/");
  EXPECT_EQ(parse_target("/api/closures/17?token=a%2Bb&x=1")->path, "/api/closures/17");
  EXPECT_EQ(parse_target("/api/closures/17?x=1&token=a%2Bb")->token, "a+b");
  EXPECT_EQ(parse_target("/?token=")->token, "");
  EXPECT_EQ(parse_target("/?nottoken=x")->token, "");
  EXPECT_EQ(parse_target("/%41#part")->path, "/A");
  for (const char* damaged : {"", "x", "http://host/", "/%4", "/%", "/%zz", "/?token=%1", "*"})
    EXPECT_FALSE(parse_target(damaged).has_value()) << damaged;
}

TEST(Access, WhatStandsInAQueryIsReadBack) {
  std::string all;
  for (int c = 1; c < 256; ++c) all += static_cast<char>(c);
  EXPECT_EQ(parse_target("/?token=" + in_query(all))->token, all);
  EXPECT_EQ(in_query("plain-Token_1.~"), "plain-Token_1.~");
}

TEST(Access, ComparesSecrets) {
  EXPECT_TRUE(same_secret("", ""));
  EXPECT_TRUE(same_secret("abc", "abc"));
  for (const char* other : {"", "a", "ab", "abd", "xbc", "abcd"})
    EXPECT_FALSE(same_secret("abc", other)) << other;
  EXPECT_FALSE(same_secret(std::string_view("a", 1), std::string_view("a\0", 2)));
}

TEST(Access, KnowsLoopbackNames) {
  for (const char* host : {"localhost", "LocalHost:80", "127.0.0.1", "127.1.2.3:8765", "[::1]",
                           "[::1]:80", "page.localhost:1"})
    EXPECT_TRUE(is_loopback_host(host)) << host;
  for (const char* host : {"", "evil.example", "localhost.evil.example", "127.0.0.1.evil.example",
                           "127.evil.example.x", "128.0.0.1", "[::2]", ".localhost", "127.0.0",
                           "192.168.0.1", "localhost@evil.example"})
    EXPECT_FALSE(is_loopback_host(host)) << host;
}

TEST(Access, WithoutATokenOnlyThisMachineIsAnswered) {
  const AccessRules open{};
  EXPECT_FALSE(refuse(open, {.host = "127.0.0.1:8765"}).has_value());
  EXPECT_FALSE(refuse(open, {.host = "localhost:8765"}).has_value());
  // A foreign name that was made to mean this machine.
  EXPECT_EQ(refuse(open, {.host = "evil.example:8765"})->status, 403);
  EXPECT_EQ(
      refuse(open, {.host = "evil.example:8765", .origin = "http://evil.example:8765"})->status,
      403);
  EXPECT_EQ(refuse(open, {.host = ""})->status, 403);
}

TEST(Access, ATokenIsAskedForFirst) {
  const AccessRules rules{.token = "correct horse"};
  EXPECT_EQ(refuse(rules, {.host = "127.0.0.1"})->status, 401);
  EXPECT_EQ(refuse(rules, {.host = "127.0.0.1", .token = "correct hors"})->status, 401);
  EXPECT_FALSE(refuse(rules, {.host = "robot.local:8765", .token = "correct horse"}).has_value());
}

TEST(Access, PagesOfOtherHostsAreRefusedUnlessListed) {
  const AccessRules rules{.origins = {"https://app.foxglove.dev"}};
  const auto status_of = [&](const char* origin) {
    const auto refusal = refuse(rules, {.host = "127.0.0.1:8765", .origin = origin});
    return refusal ? refusal->status : 200;
  };
  EXPECT_EQ(status_of("http://127.0.0.1:8765"), 200);
  EXPECT_EQ(status_of("http://localhost:3000"), 200);
  EXPECT_EQ(status_of("https://app.foxglove.dev"), 200);
  EXPECT_EQ(status_of("https://APP.foxglove.dev"), 200);
  for (const char* origin :
       {"https://evil.example", "http://app.foxglove.dev", "https://app.foxglove.dev.evil.example",
        "null", "", "file://", "127.0.0.1", "http://localhost.evil.example"})
    EXPECT_EQ(status_of(origin), 403) << origin;
  // By the name under which it was called.
  EXPECT_FALSE(refuse({.token = "12345678"},
                      {.host = "robot:8765", .origin = "http://robot:8765", .token = "12345678"})
                   .has_value());
  EXPECT_TRUE(refuse({.token = "12345678"},
                     {.host = "robot:8765", .origin = "http://robot:8766", .token = "12345678"})
                  .has_value());
}

TEST(Access, TheFirstSubProtocolThatIsSpokenIsChosen) {
  EXPECT_EQ(choose_sub_protocol("foxglove.websocket.v1"), "foxglove.websocket.v1");
  EXPECT_EQ(choose_sub_protocol("a, foxglove.sdk.v1 ,foxglove.websocket.v1"), "foxglove.sdk.v1");
  EXPECT_FALSE(choose_sub_protocol("").has_value());
  EXPECT_FALSE(choose_sub_protocol("foxglove.websocket.v2, ,").has_value());
}

}  // namespace
}  // namespace loopstone
