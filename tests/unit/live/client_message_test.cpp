#include "live/client_message.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <limits>
#include <string>

namespace loopstone {
namespace {

std::string control_bytes(int command, float speed, int had_seek, std::uint64_t time,
                          const std::string& id, std::uint32_t length) {
  std::string bytes = "\x03";
  const auto append = [&](auto value, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
      bytes += static_cast<char>((static_cast<std::uint64_t>(value) >> (8 * i)) & 0xFFU);
  };
  append(command, 1);
  append(std::bit_cast<std::uint32_t>(speed), 4);
  append(had_seek, 1);
  append(time, 8);
  append(length, 4);
  return bytes + id;
}

bool is_refused(const ClientMessage& message) {
  return std::holds_alternative<RefusedRequest>(message);
}

TEST(ClientMessage, SubscribesAndUnsubscribes) {
  const auto wish = std::get<SubscribeRequest>(parse_client_text(
      R"({"op":"subscribe","subscriptions":[{"id":7,"channelId":0},{"id":4294967295,"channelId":3}]})"));
  ASSERT_EQ(wish.subscriptions.size(), 2U);
  EXPECT_EQ(wish.subscriptions[0].id, 7U);
  EXPECT_EQ(wish.subscriptions[1].id, 4294967295U);
  EXPECT_EQ(wish.subscriptions[1].channel, 3U);
  const auto end = std::get<UnsubscribeRequest>(
      parse_client_text(R"({"op":"unsubscribe","subscriptionIds":[7,8]})"));
  EXPECT_EQ(end.ids, (std::vector<std::uint32_t>{7, 8}));
}

TEST(ClientMessage, KnowsWhatIsNotOffered) {
  for (const char* op : {"advertise", "getParameters", "subscribeConnectionGraph", "fetchAsset"}) {
    const auto message = parse_client_text(std::string(R"({"op":")") + op + R"("})");
    ASSERT_TRUE(std::holds_alternative<UnsupportedRequest>(message)) << op;
    EXPECT_EQ(std::get<UnsupportedRequest>(message).what, op);
  }
  EXPECT_TRUE(std::holds_alternative<UnsupportedRequest>(parse_client_bytes("\x01....data")));
  EXPECT_TRUE(std::holds_alternative<UnsupportedRequest>(parse_client_bytes("\x02")));
}

TEST(ClientMessage, RefusesWhatIsNone) {
  for (const char* text :
       {"",
        "{",
        "null",
        "[]",
        "7",
        "\"subscribe\"",
        "{}",
        R"({"op":7})",
        R"({"op":"dance"})",
        R"({"op":"subscribe"})",
        R"({"op":"subscribe","subscriptions":{}})",
        R"({"op":"subscribe","subscriptions":[7]})",
        R"({"op":"subscribe","subscriptions":[{"id":1}]})",
        R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}]})",
        R"({"op":"subscribe","subscriptions":[{"id":1.5,"channelId":1}]})",
        R"({"op":"subscribe","subscriptions":[{"id":4294967296,"channelId":1}]})",
        R"({"op":"subscribe","subscriptions":[{"id":"1","channelId":1}]})",
        R"({"op":"unsubscribe","subscriptionIds":["a"]})",
        R"({"op":"unsubscribe","subscriptionIds":7})",
        "{\"op\":\"subscribe\"} trailing",
        "\xff\xfe"}) {
    EXPECT_TRUE(is_refused(parse_client_text(text))) << text;
  }
}

TEST(ClientMessage, RefusesWhatIsEndless) {
  EXPECT_TRUE(is_refused(parse_client_text(std::string(60'000, '['))));
  EXPECT_TRUE(is_refused(parse_client_text(std::string(60'000, '{'))));
  std::string many = R"({"op":"unsubscribe","subscriptionIds":[1)";
  for (std::size_t i = 0; i < kMostSubscriptions; ++i) many += ",1";
  EXPECT_TRUE(is_refused(parse_client_text(many + "]}")));
  // Brackets in texts do not nest.
  EXPECT_TRUE(std::holds_alternative<UnsupportedRequest>(
      parse_client_text(R"({"op":"fetchAsset","uri":"[[[[[[[[[[\"[[[["})")));
}

TEST(ClientMessage, ReadsPlaybackControl) {
  const auto play = std::get<PlaybackControl>(
      parse_client_bytes(control_bytes(0, 2.5F, 1, 1'500'000'000, "r1", 2)));
  EXPECT_TRUE(play.play);
  EXPECT_EQ(play.speed, 2.5);
  ASSERT_TRUE(play.seek_to.has_value());
  EXPECT_EQ(play.seek_to->nanoseconds, 1'500'000'000);
  EXPECT_EQ(play.request, "r1");
  const auto pause =
      std::get<PlaybackControl>(parse_client_bytes(control_bytes(1, 1.0F, 0, 9, "", 0)));
  EXPECT_FALSE(pause.play);
  EXPECT_FALSE(pause.seek_to.has_value());
  const auto fast =
      std::get<PlaybackControl>(parse_client_bytes(control_bytes(0, 1e30F, 0, 0, "", 0)));
  EXPECT_LE(fast.speed, 1e6);
}

TEST(ClientMessage, RefusesDamagedPlaybackControl) {
  const std::string good = control_bytes(0, 1.0F, 1, 5, "abc", 3);
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_TRUE(is_refused(parse_client_bytes(good.substr(0, size)))) << size;
  EXPECT_TRUE(is_refused(parse_client_bytes(good + "d")));
  EXPECT_TRUE(is_refused(parse_client_bytes(control_bytes(2, 1.0F, 0, 0, "", 0))));
  EXPECT_TRUE(is_refused(parse_client_bytes(control_bytes(0, -1.0F, 0, 0, "", 0))));
  EXPECT_TRUE(is_refused(
      parse_client_bytes(control_bytes(0, std::numeric_limits<float>::quiet_NaN(), 0, 0, "", 0))));
  EXPECT_TRUE(is_refused(parse_client_bytes(control_bytes(0, 1.0F, 1, ~0ULL, "", 0))));
  EXPECT_TRUE(is_refused(parse_client_bytes(control_bytes(0, 1.0F, 0, 0, "", 0xFFFFFFFFU))));
  EXPECT_TRUE(
      is_refused(parse_client_bytes(control_bytes(0, 1.0F, 0, 0, std::string(300, 'x'), 300))));
  EXPECT_TRUE(is_refused(parse_client_bytes("\x09")));
}

}  // namespace
}  // namespace loopstone
