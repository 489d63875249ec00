#include "formats/mcap_stream.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "mcap_builds.hpp"
#include "support/recording_builder.hpp"

namespace loopstone {
namespace {

using test::build_mcap;
using test::BuiltMessage;
using test::McapBuild;
using test::messages_of;
using test::some_messages;

/// Bytes that come in pieces of any size, as over a network.
class Pieces final : public ByteSource {
 public:
  explicit Pieces(std::string bytes, std::uint64_t seed = 1)
      : bytes_(std::move(bytes)), rng_(seed) {}
  std::size_t read(std::span<char> buffer) override {
    const std::size_t left = std::min(buffer.size(), bytes_.size() - done_);
    const std::size_t count = std::min<std::size_t>(left, 1 + rng_.below(97));
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(done_), count, buffer.begin());
    done_ += count;
    return count;
  }
  std::int64_t bytes_done() const override { return static_cast<std::int64_t>(done_); }
  std::int64_t bytes_total() const override { return 0; }

 private:
  std::string bytes_;
  std::size_t done_ = 0;
  Rng rng_;
};

std::unique_ptr<StreamedRecording> stream_of(const std::string& bytes) {
  return stream_mcap(std::make_unique<Pieces>(bytes), "a stream", {}, {});
}

TEST(McapStream, GivesWhatTheFileGives) {
  const auto messages = some_messages(60);
  for (const McapBuild& build : test::mcap_builds()) {
    const std::string bytes = build_mcap(messages, build).bytes;
    const auto stream = stream_of(bytes);
    stream->survey_is_over();
    EXPECT_EQ(messages_of(*stream), messages) << test::words(build);
    EXPECT_FALSE(stream->is_indexed());
  }
}

TEST(McapStream, WhatWasLookedAtIsGivenOnceMoreAndNotTwice) {
  const auto messages = some_messages(40);
  const auto stream = stream_of(build_mcap(messages, {.packing = Packing::kZstd}).bytes);
  for (int i = 0; i < 15; ++i) ASSERT_TRUE(stream->next());
  stream->rewind();
  stream->want([](const RecordedTopic& topic) { return topic.name == "/tf"; });
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(stream->next());
  stream->want({});
  stream->rewind();
  stream->survey_is_over();
  EXPECT_EQ(messages_of(*stream), messages);
  stream->rewind();
  EXPECT_FALSE(stream->next());
}

TEST(McapStream, GivesOnlyWhatIsWanted) {
  const auto messages = some_messages(40);
  const auto stream = stream_of(build_mcap(messages, {}).bytes);
  stream->want([](const RecordedTopic& topic) { return topic.name == "/scan"; });
  stream->survey_is_over();
  std::vector<BuiltMessage> wanted;
  std::ranges::copy_if(messages, std::back_inserter(wanted),
                       [](const BuiltMessage& message) { return message.topic == "/scan"; });
  EXPECT_EQ(messages_of(*stream), wanted);
}

TEST(McapStream, ThatIsCutGivesWhatCameAndSaysWhere) {
  const auto messages = some_messages(30);
  for (const bool has_chunks : {true, false}) {
    const std::string bytes =
        build_mcap(messages,
                   {.packing = Packing::kLz4, .has_chunks = has_chunks, .is_closed = false})
            .bytes;
    for (std::size_t size = 8; size < bytes.size(); size += 41) {
      const auto stream = stream_of(bytes.substr(0, size));
      stream->survey_is_over();
      std::vector<BuiltMessage> came;
      try {
        while (const auto message = stream->next()) {
          came.push_back({stream->topics()[message->topic].name,
                          message->recorded,
                          {message->bytes.begin(), message->bytes.end()}});
        }
      } catch (const DataError& error) {
        EXPECT_NE(std::string(error.what()).find("a stream"), std::string::npos);
      }
      ASSERT_LE(came.size(), messages.size());
      EXPECT_TRUE(std::equal(came.begin(), came.end(), messages.begin())) << size;
    }
  }
}

TEST(McapStream, ThatIsDamagedIsRefusedThere) {
  const auto messages = some_messages(30);
  const std::string bytes = build_mcap(messages, {.packing = Packing::kZstd}).bytes;
  Rng rng(7);
  int refused = 0;
  for (int i = 0; i < 200; ++i) {
    std::string damaged = bytes;
    damaged[8 + rng.below(damaged.size() / 2)] ^= static_cast<char>(1U << rng.below(8));
    try {
      const auto stream = stream_of(damaged);
      stream->survey_is_over();
      (void)messages_of(*stream);
    } catch (const DataError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 100) << "chunks have checksums";
}

TEST(McapStream, ThatIsNoneIsRefused) {
  EXPECT_THROW((void)stream_of("FLASER 3 1 2 3 0 0 0 0 0 0 1.5 host 0\n"), DataError);
  EXPECT_THROW((void)stream_of(""), DataError);
}

}  // namespace
}  // namespace loopstone
