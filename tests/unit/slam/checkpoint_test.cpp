// A run that saves its state now and then, is ended, and goes on from what it saved.

#include "loopstone/slam/checkpoint.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"
#include "support/passage_drive.hpp"
#include "support/saved_state.hpp"

namespace loopstone {
namespace {

using test::short_submaps;
using test::state_of;
using testing::HasSubstr;

constexpr int kScans = 24;

std::vector<SensorMessage> recording() {
  std::vector<SensorMessage> messages;
  for (int i = 0; i < kScans; ++i) {
    for (SensorMessage& message : test::passage_messages(i)) messages.push_back(std::move(message));
  }
  return messages;
}

Checkpoint::NextMessage source_of(const std::vector<SensorMessage>& messages, std::size_t& next) {
  return [&messages, &next]() -> std::optional<SensorMessage> {
    if (next == messages.size()) return {};
    return messages[next++];
  };
}

Session copy_of(const Session& session) {
  ByteWriter writer;
  writer(session);
  const std::string bytes = writer.take();
  Session copy;
  ByteReader reader(bytes);
  reader(copy);
  return copy;
}

/// The first messages of a recording, and the session that they lead to.
Session session_after(std::size_t messages, const SessionTerms& terms = {}) {
  std::optional<Session> saved;
  Mapper mapper({}, short_submaps(), {1});
  Checkpoint checkpoint({.write =
                             [&](const Session& session) {
                               saved = copy_of(session);
                               return std::int64_t{1};
                             }},
                        terms);
  const auto all = recording();
  for (std::size_t i = 0; i < messages; ++i) {
    mapper.add(all[i]);
    checkpoint.after(all[i], mapper);
  }
  checkpoint.after_last(mapper);
  EXPECT_EQ(checkpoint.cost().saved, 1);
  return std::move(saved.value());
}

std::string poses_of_run(MapResult result) {
  std::string bytes = state_of(result.graph);
  for (const StampedPose2& pose : result.trajectory.poses())
    bytes += state_of(pose.stamp, pose.pose);
  return bytes;
}

TEST(Checkpoint, ARunGoesOnFromItsSessionToTheSameBytes) {
  const auto messages = recording();
  Mapper whole({}, short_submaps(), {1});
  for (const SensorMessage& message : messages) whole.add(message);
  const std::string expected = poses_of_run(whole.finish());

  Session session = session_after(messages.size() / 2);
  session.wall_s = 7.0;
  session.cpu_s = 8.0;
  Mapper mapper({}, short_submaps(), {1});
  Checkpoint checkpoint({}, {});
  std::size_t next = 0;
  checkpoint.resume(std::move(session), mapper, source_of(messages, next));
  EXPECT_EQ(next, messages.size() / 2) << "the log was read up to where it was saved";
  EXPECT_EQ(checkpoint.earlier_wall_s(), 7.0);
  EXPECT_EQ(checkpoint.earlier_cpu_s(), 8.0);
  for (; next < messages.size(); ++next) {
    mapper.add(messages[next]);
    checkpoint.after(messages[next], mapper);
  }
  EXPECT_EQ(checkpoint.log().messages(), static_cast<std::int64_t>(messages.size()));
  EXPECT_EQ(poses_of_run(mapper.finish()), expected);
}

TEST(Checkpoint, ASessionOfAnotherRunOrLogIsRefused) {
  const auto refusal = [](const SessionTerms& terms, const std::vector<SensorMessage>& messages) {
    Mapper mapper({}, short_submaps(), {1});
    Checkpoint checkpoint({}, terms);
    std::size_t next = 0;
    try {
      checkpoint.resume(session_after(30), mapper, source_of(messages, next));
    } catch (const UsageError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  auto messages = recording();
  EXPECT_EQ(refusal({}, messages), "");
  EXPECT_THAT(refusal({.options_toml = "a = 1\n"}, messages), HasSubstr("another run: options"));
  EXPECT_THAT(refusal({.max_scans = 3}, messages), HasSubstr("--max-scans: 0 then, 3 now"));
  messages.erase(messages.begin() + 5);
  EXPECT_THAT(refusal({}, messages), HasSubstr("another log"));
  messages.resize(10);
  EXPECT_THAT(refusal({}, messages), HasSubstr("another log")) << "it ended too early";
}

TEST(Checkpoint, WhatDiffersIsNamedWithBothValues) {
  const SessionTerms terms{.version = "1", .options_toml = "[a]\nb = 1\n", .robot_toml = "c = 2\n"};
  const auto differs = [&](const auto& change) {
    SessionTerms other = terms;
    change(other);
    return difference(terms, other);
  };
  EXPECT_EQ(differs([](SessionTerms&) {}), "");
  EXPECT_EQ(differs([](SessionTerms& t) { t.version = "2"; }), "loopstone: 1 then, 2 now");
  EXPECT_EQ(differs([](SessionTerms& t) { t.options_toml = "[a]\nb = 3\n"; }),
            "options: [a] `b = 1` then, `b = 3` now");
  EXPECT_EQ(differs([](SessionTerms& t) { t.robot_toml += "d = 1\n"; }),
            "robot: one has more than the other");
  EXPECT_EQ(differs([](SessionTerms& t) { t.mounts_from_log = false; }),
            "--robot: not given then, given now");
  EXPECT_EQ(differs([](SessionTerms& t) { t.start_s = 2.0; }), "--start: 0 then, 2 now");
  EXPECT_EQ(differs([](SessionTerms& t) { t.duration_s = 2.5; }), "--duration: 0 then, 2.5 now");
}

TEST(Checkpoint, ASessionThatCannotBeKeptIsToldOnceAndTheRunGoesOn) {
  int tried = 0;
  std::vector<std::string> told;
  Mapper mapper({}, short_submaps(), {1});
  Checkpoint checkpoint({.every_s = 1e-9,
                         .write = [&tried](const Session&) -> std::int64_t {
                           ++tried;
                           throw std::runtime_error("no room");
                         },
                         .failed = [&told](const std::string& reason) { told.push_back(reason); }},
                        {});
  for (const SensorMessage& message : recording()) {
    mapper.add(message);
    checkpoint.after(message, mapper);
  }
  checkpoint.after_last(mapper);
  EXPECT_GT(tried, 1);
  EXPECT_EQ(told, std::vector<std::string>{"no room"});
  EXPECT_EQ(checkpoint.cost().saved, 0);
  EXPECT_EQ(mapper.finish().trajectory.size(), static_cast<std::size_t>(kScans));
}

TEST(Checkpoint, WithoutAWriterNothingIsSaved) {
  Mapper mapper({}, short_submaps(), {1});
  Checkpoint checkpoint({.every_s = 1e-9}, {});
  for (const SensorMessage& message : recording()) {
    mapper.add(message);
    checkpoint.after(message, mapper);
  }
  checkpoint.after_last(mapper);
  EXPECT_EQ(checkpoint.cost().saved, 0);
}

}  // namespace
}  // namespace loopstone
