#include "live/view_hub.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

using Json = nlohmann::json;
using testing::ElementsAre;

std::string subscribe(std::uint32_t id, std::uint32_t channel) {
  return Json{{"op", "subscribe"}, {"subscriptions", {{{"id", id}, {"channelId", channel}}}}}
      .dump();
}

/// Everything that waits for a client: JSON as it is, messages as "ID:BYTES", playback as "play N",
/// time as "time".
std::vector<std::string> all_for(ViewHub& hub, ViewHub::Client client) {
  std::vector<std::string> all;
  while (auto frame = hub.next_frame(client)) {
    const char kind = frame->is_text ? 'j' : frame->head.front();
    if (kind == 'j') all.push_back(frame->head);
    if (kind == 1) {
      std::uint32_t id = 0;
      std::memcpy(&id, frame->head.data() + 1, sizeof id);
      all.push_back(std::to_string(id) + ":" + *frame->body);
    }
    if (kind == 2) all.emplace_back("time");
    if (kind == 5) all.push_back("play " + std::to_string(frame->head[1]));
  }
  return all;
}

/// A hub with a channel of each kind, whose ids are these.
struct Hub : testing::Test {
  static constexpr std::uint32_t kEvery = 0;
  static constexpr std::uint32_t kLatest = 1;
  static constexpr std::uint32_t kDroppable = 2;
  static constexpr std::uint32_t kChanges = 3;

  Hub() {
    hub.add_channel({.topic = "/every", .policy = SendPolicy::kEvery});
    hub.add_channel({.topic = "/latest", .policy = SendPolicy::kLatest});
    hub.add_channel({.topic = "/droppable", .policy = SendPolicy::kDroppable});
    hub.add_channel(
        {.topic = "/changes", .policy = SendPolicy::kChanges, .whole = [this] {
           // As the program's own lock would be taken.
           ++wholes;
           return state.empty() ? std::nullopt : std::optional<ViewMessage>({Stamp{1}, state});
         }});
  }
  /// One that has read its greeting.
  ViewHub::Client greeted() {
    const auto client = hub.join([this] { ++wakes; });
    EXPECT_TRUE(client.has_value());
    (void)all_for(hub, *client);
    return *client;
  }

  ViewServerOptions options{.name = "office", .range = PlaybackRange{Stamp{0}, Stamp{5}}};
  ViewServerLimits limits{.clients = 2, .waiting_bytes = 1000};
  std::string state{};
  int wholes = 0;
  int wakes = 0;
  ViewHub hub{options, limits, "session"};
};

TEST_F(Hub, GreetsWithInfoAndChannels) {
  hub.set_time(Stamp{7});
  hub.set_playback({.status = PlaybackStatus::kPaused, .did_seek = true, .request = "r"});
  const auto client = hub.join([this] { ++wakes; });
  ASSERT_TRUE(client.has_value());
  EXPECT_GT(wakes, 0);
  const auto all = all_for(hub, *client);
  ASSERT_EQ(all.size(), 4U);
  const Json info = Json::parse(all[0]);
  EXPECT_EQ(info["op"], "serverInfo");
  EXPECT_EQ(info["name"], "office");
  EXPECT_EQ(info["capabilities"], (Json{"time", "playbackControl"}));
  EXPECT_EQ(info["dataEndTime"], (Json{{"sec", 0}, {"nsec", 5}}));
  EXPECT_EQ(info["sessionId"], "session");
  const Json channels = Json::parse(all[1])["channels"];
  ASSERT_EQ(channels.size(), 4U);
  EXPECT_EQ(channels[2]["id"], 2);
  EXPECT_EQ(channels[2]["topic"], "/droppable");
  EXPECT_THAT(std::vector(all.begin() + 2, all.end()), ElementsAre("time", "play 1"));
}

TEST_F(Hub, TellsOfChannelsThatComeLater) {
  const auto client = greeted();
  hub.add_channel({.topic = "/late"});
  const auto all = all_for(hub, client);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(Json::parse(all[0])["channels"][0]["id"], 4);
  EXPECT_THROW(hub.add_channel({.topic = "/late"}), UsageError);
}

TEST_F(Hub, OnlySubscribersGetMessages) {
  const auto client = greeted();
  const auto other = greeted();
  hub.receive_text(client, subscribe(70, kEvery));
  EXPECT_EQ(hub.subscribers({kEvery}), 1U);
  EXPECT_EQ(hub.subscribers({kLatest}), 0U);
  hub.publish({kEvery}, Stamp{1}, "a");
  EXPECT_THAT(all_for(hub, client), ElementsAre("70:a"));
  EXPECT_THAT(all_for(hub, other), ElementsAre());
  hub.publish({kEvery}, Stamp{1}, "b");
  hub.receive_text(client, R"({"op":"unsubscribe","subscriptionIds":[70]})");
  EXPECT_THAT(all_for(hub, client), ElementsAre());
}

TEST_F(Hub, WhoSubscribesLateGetsWhatCounts) {
  hub.publish({kEvery}, Stamp{1}, "gone");
  hub.publish({kLatest}, Stamp{1}, "old");
  hub.publish({kLatest}, Stamp{2}, "new");
  hub.publish({kDroppable}, Stamp{1}, "gone");
  hub.publish({kDroppable}, Stamp{2}, "where the robot is");
  state = "tiles 1 and 2";
  hub.publish({kChanges}, Stamp{1}, "tile 2");
  const auto client = greeted();
  for (std::uint32_t i = 0; i < 4; ++i) hub.receive_text(client, subscribe(10 + i, i));
  EXPECT_THAT(all_for(hub, client),
              ElementsAre("11:new", "12:where the robot is", "13:tiles 1 and 2"));
  hub.publish({kChanges}, Stamp{1}, "tile 3");
  EXPECT_THAT(all_for(hub, client), ElementsAre("13:tile 3"));
}

TEST_F(Hub, AStateThatIsNotThereIsNotTold) {
  const auto client = greeted();
  hub.receive_text(client, subscribe(1, kChanges));
  hub.publish({kLatest}, Stamp{}, "x");
  EXPECT_THAT(all_for(hub, client), ElementsAre());
  EXPECT_EQ(wholes, 1);
}

TEST_F(Hub, TheSlowMissScansAndNothingElse) {
  const auto slow = greeted();
  for (std::uint32_t i = 0; i < 4; ++i) hub.receive_text(slow, subscribe(i, i));
  (void)all_for(hub, slow);
  for (int i = 0; i < 1000; ++i) {
    state = "all " + std::to_string(i);
    hub.publish({kDroppable}, Stamp{i}, "scan");
    hub.publish({kChanges}, Stamp{i}, "tile");
    hub.publish({kLatest}, Stamp{i}, "graph " + std::to_string(i));
    if (i % 100 == 0) hub.publish({kEvery}, Stamp{i}, "closure " + std::to_string(i));
  }
  const auto all = all_for(hub, slow);
  const auto count_of = [&](const std::string& part) {
    return std::ranges::count_if(all, [&](const auto& one) { return one.find(part) != one.npos; });
  };
  EXPECT_EQ(count_of("closure"), 10);
  EXPECT_EQ(count_of("graph"), 1);
  EXPECT_EQ(count_of("graph 999"), 1);
  EXPECT_EQ(count_of("all 999"), 1);
  EXPECT_EQ(count_of("tile"), 0);
  EXPECT_GT(count_of("scan"), 0);
  EXPECT_LT(count_of("scan"), 200);
}

TEST_F(Hub, WhoLetsTooMuchWaitIsOverrun) {
  const auto slow = greeted();
  hub.receive_text(slow, subscribe(0, kEvery));
  EXPECT_FALSE(hub.is_overrun(slow));
  for (int i = 0; i < 200; ++i) hub.publish({kEvery}, Stamp{i}, "closure");
  EXPECT_TRUE(hub.is_overrun(slow));
  EXPECT_FALSE(hub.next_frame(slow).has_value());
}

TEST_F(Hub, ClientsAreLimited) {
  const auto first = greeted();
  (void)greeted();
  EXPECT_FALSE(hub.join([] {}).has_value());
  hub.leave(first);
  EXPECT_EQ(hub.clients(), 1U);
  EXPECT_TRUE(hub.join([] {}).has_value());
  // Of one that is gone nothing is known.
  hub.receive_text(first, subscribe(1, 1));
  EXPECT_FALSE(hub.next_frame(first).has_value());
}

TEST_F(Hub, NonsenseIsAnsweredInWords) {
  const auto client = greeted();
  hub.receive_text(client, "no JSON");
  hub.receive_text(client, R"({"op":"getParameters"})");
  hub.receive_text(client, subscribe(1, 99));
  hub.receive_text(client, subscribe(2, kEvery));
  hub.receive_text(client, subscribe(2, kLatest));
  hub.receive_text(client, R"({"op":"unsubscribe","subscriptionIds":[3]})");
  hub.receive_bytes(client, "\x2a");
  const auto all = all_for(hub, client);
  ASSERT_EQ(all.size(), 6U);
  for (const auto& one : all) EXPECT_EQ(Json::parse(one)["op"], "status") << one;
}

TEST_F(Hub, PlaybackIsHandedOnAndToldToAll) {
  std::vector<PlaybackControl> asked;
  hub.on_playback([&](const PlaybackControl& control) { asked.push_back(control); });
  const auto client = greeted();
  const auto other = greeted();
  std::string bytes("\x03\x01\0\0\x80\x3f\0\0\0\0\0\0\0\0\0\x01\0\0\0r", 20);
  hub.receive_bytes(client, bytes);
  ASSERT_EQ(asked.size(), 1U);
  EXPECT_FALSE(asked[0].play);
  EXPECT_EQ(asked[0].request, "r");
  hub.set_playback({.status = PlaybackStatus::kPaused, .request = "r"});
  EXPECT_THAT(all_for(hub, client), ElementsAre("play 1"));
  EXPECT_THAT(all_for(hub, other), ElementsAre("play 1"));
}

TEST(HubWithoutRange, HasNothingToPlay) {
  ViewHub hub({}, {}, "s");
  const auto client = hub.join([] {});
  ASSERT_TRUE(client.has_value());
  hub.set_playback({});
  const auto all = all_for(hub, *client);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(Json::parse(all[0])["capabilities"], Json{"time"});
  hub.receive_bytes(*client, std::string("\x03\x01\0\0\x80\x3f\0\0\0\0\0\0\0\0\0\0\0\0\0", 19));
  EXPECT_EQ(Json::parse(all_for(hub, *client).at(0))["level"], 1);
}

}  // namespace
}  // namespace loopstone
