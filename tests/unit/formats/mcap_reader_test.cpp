#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "chunked_checks.hpp"
#include "formats/recording.hpp"
#include "mcap_builds.hpp"
#include "support/recorded_data.hpp"
#include "support/recording_builder.hpp"
#include "support/recording_damage.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using test::build_mcap;
using test::BuiltMessage;
using test::BuiltRecording;
using test::Damage;
using test::McapBuild;
using test::messages_of;
using test::some_messages;

TEST(McapReader, every_way_to_write_a_file_gives_the_same_messages) {
  const auto messages = some_messages(60);
  for (const McapBuild& build : test::mcap_builds()) {
    Damage damage;
    const BuiltRecording file = build_mcap(messages, build);
    const auto recording = read_mcap(file.bytes, damage.options());
    EXPECT_EQ(messages_of(*recording), messages) << test::words(build);
    EXPECT_EQ(damage.reasons, std::vector<std::string>{}) << test::words(build);
    const bool is_indexed =
        build.is_closed && build.has_summary && build.repeats_channels && build.repeats_schemas;
    EXPECT_EQ(recording->is_indexed(), is_indexed) << test::words(build);
    EXPECT_EQ(recording->notes().empty(), is_indexed) << test::words(build);
    EXPECT_EQ(recording->topics().size(), 3U) << test::words(build);
    recording->rewind();
    EXPECT_EQ(messages_of(*recording), messages) << test::words(build);
  }
}

TEST(McapReader, topics_say_type_definition_and_count) {
  const auto messages = some_messages(60);
  std::map<std::string, std::int64_t> counts;
  for (const BuiltMessage& message : messages) ++counts[message.topic];
  const BuiltRecording file =
      build_mcap(messages, {.packing = Packing::kZstd,
                            .encoding = "cdr",
                            .schema_encoding = "ros2msg",
                            .channel_metadata = {{"offered_qos_profiles", "- history: 1"},
                                                 {"topic_type_hash", "RIHS01_00"}}});
  const auto recording = read_mcap(file.bytes, {});
  ASSERT_EQ(recording->topics().size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const RecordedTopic& topic = recording->topics()[i];
    EXPECT_EQ(topic.name, test::built_topics()[i].name);
    EXPECT_EQ(topic.type, test::built_topics()[i].type);
    EXPECT_EQ(topic.definition.text, test::built_topics()[i].definition);
    EXPECT_EQ(topic.definition.language, DefinitionLanguage::kRos2Msg);
    EXPECT_EQ(topic.format, WireFormat::kCdr);
    EXPECT_EQ(topic.hash, "RIHS01_00");
    EXPECT_EQ(topic.unreadable, "");
    EXPECT_EQ(topic.messages, counts[topic.name]);
  }
}

TEST(McapReader, encodings_that_are_none_of_ros_are_named) {
  const auto messages = some_messages(10);
  const auto topic_of = [&](const McapBuild& build) {
    return read_mcap(build_mcap(messages, build).bytes, {})->topics().at(0);
  };
  EXPECT_EQ(topic_of({.encoding = "protobuf"}).unreadable, "encoded as protobuf");
  EXPECT_NE(topic_of({.encoding = ""}).unreadable, "");
  EXPECT_EQ(topic_of({.encoding = "ros1"}).format, WireFormat::kRos1);
  EXPECT_EQ(topic_of({.schema_encoding = "ros1msg"}).definition.language,
            DefinitionLanguage::kRos1Msg);
  EXPECT_EQ(topic_of({.schema_encoding = "ros2idl"}).definition.language,
            DefinitionLanguage::kRos2Idl);
  EXPECT_EQ(topic_of({.schema_encoding = "jsonschema"}).definition.language,
            DefinitionLanguage::kNone);
}

TEST(McapReader, a_file_gives_what_memory_gives_and_says_where) {
  const auto messages = some_messages(60);
  const BuiltRecording file = build_mcap(messages, {});
  const test::TempDir dir;
  const auto recording = open_mcap(dir.write("a.mcap", file.bytes), {});
  std::size_t i = 0;
  while (const auto message = recording->next()) {
    const Location where = message->where();
    EXPECT_EQ(where.path, dir / "a.mcap");
    constexpr std::size_t kHead = 9 + 22;
    EXPECT_EQ(file.bytes.substr(static_cast<std::size_t>(*where.byte_offset) + kHead,
                                messages[i].bytes.size()),
              messages[i].bytes);
    ++i;
  }
  EXPECT_EQ(i, messages.size());
}

TEST(McapReader, only_wanted_topics_are_given_and_chunks_without_them_are_not_unpacked) {
  auto messages = some_messages(60);
  for (std::size_t i = 0; i < messages.size(); ++i) {
    messages[i].topic = i / 7 == 3 ? "/scan" : "/tf";
  }
  for (const bool has_message_indexes : {true, false}) {
    const McapBuild build{.packing = Packing::kZstd, .has_message_indexes = has_message_indexes};
    BuiltRecording file = build_mcap(messages, build);
    // Only a chunk that is looked into tells that it is damaged.
    const auto& spoiled = file.parts[5];
    std::fill(file.bytes.begin() + static_cast<long>((spoiled.begin + spoiled.end) / 2),
              file.bytes.begin() + static_cast<long>(spoiled.end), 'x');
    Damage damage;
    const auto recording = read_mcap(file.bytes, damage.options());
    recording->want([](const RecordedTopic& topic) { return topic.name == "/scan"; });
    const std::vector<BuiltMessage> expected(messages.begin() + 21, messages.begin() + 28);
    EXPECT_EQ(messages_of(*recording), expected);
    // A chunk of which nothing is known may hold anything.
    EXPECT_EQ(damage.reasons.empty(), has_message_indexes);
    recording->want({});
    recording->rewind();
    EXPECT_GT(messages_of(*recording).size(), 50U);
    EXPECT_FALSE(damage.reasons.empty());
  }
}

TEST(McapReader, a_file_that_is_cut_anywhere_gives_the_messages_before) {
  const auto messages = some_messages(30);
  for (const McapBuild& build : test::mcap_builds()) {
    test::expect_what_is_before_cuts(build_mcap(messages, build), messages, 8, 11, read_mcap,
                                     test::words(build));
  }
}

TEST(McapReader, a_chunk_that_is_cut_gives_what_is_in_it) {
  const auto messages = some_messages(3000);
  for (McapBuild build : test::mcap_builds()) {
    build.per_chunk = messages.size();
    if (!build.has_chunks) continue;
    const BuiltRecording file = build_mcap(messages, build);
    const std::size_t half = (file.parts[0].begin + file.parts[0].end) / 2;
    Damage damage;
    const auto recording =
        read_mcap(std::string_view(file.bytes).substr(0, half), damage.options());
    const auto got = messages_of(*recording);
    EXPECT_GT(got.size(), 500U) << test::words(build);  // zstd has blocks of 128 KiB
    EXPECT_LT(got.size(), 2000U) << test::words(build);
    ASSERT_EQ(damage.reasons.size(), 1U) << test::words(build);
    recording->rewind();
    EXPECT_EQ(messages_of(*recording), got);
    EXPECT_EQ(damage.reasons.size(), 1U);  // it is told once
  }
}

TEST(McapReader, a_wrong_checksum_is_told_and_the_messages_are_given) {
  const auto messages = some_messages(60);
  for (const Packing packing : {Packing::kNone, Packing::kLz4, Packing::kZstd}) {
    Damage damage;
    const BuiltRecording file =
        build_mcap(messages, {.packing = packing, .has_wrong_checksums = true});
    const auto recording = read_mcap(file.bytes, damage.options());
    EXPECT_EQ(messages_of(*recording), messages);
    ASSERT_EQ(damage.reasons.size(), file.parts.size());
    EXPECT_NE(damage.reasons[0].find("checksum"), std::string::npos) << damage.reasons[0];
  }
}

TEST(McapReader, a_damaged_summary_is_left_alone) {
  const auto messages = some_messages(60);
  BuiltRecording file = build_mcap(messages, {});
  const std::size_t topic = file.bytes.rfind("/camera");
  file.bytes[topic + 1] = 'X';
  const auto recording = read_mcap(file.bytes, {});
  EXPECT_FALSE(recording->is_indexed());
  EXPECT_EQ(recording->notes(), std::vector<std::string>{"its index is damaged"});
  EXPECT_EQ(messages_of(*recording), messages);
}

TEST(McapReader, two_files_one_behind_the_other_are_read_as_one) {
  const auto messages = some_messages(60);
  const std::vector<BuiltMessage> first(messages.begin(), messages.begin() + 30);
  const std::vector<BuiltMessage> second(messages.begin() + 30, messages.end());
  const BuiltRecording one = build_mcap(first, {.packing = Packing::kLz4});
  const BuiltRecording two = build_mcap(second, {});
  Damage damage;
  const std::string bytes = one.bytes + two.bytes;
  EXPECT_EQ(messages_of(*read_mcap(bytes, damage.options())), messages);
  EXPECT_EQ(damage.reasons, std::vector<std::string>{});
}

TEST(McapReader, what_is_undamaged_is_found_wherever_the_damage_is) {
  const auto messages = some_messages(60);
  const auto variants = test::mcap_builds();
  std::size_t placed = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    const McapBuild& build = variants[seed % variants.size()];
    const auto spoiled = test::damaged(build_mcap(messages, build), messages.size(), seed);
    const std::string what = test::words(build) + ", seed " + std::to_string(seed);
    test::expect_what_is_undamaged(spoiled, messages, read_mcap, what);
    placed += test::expect_by_place(spoiled.bytes, read_mcap, what);
  }
  EXPECT_GT(placed, 500 * messages.size() / 2);
}

TEST(McapReader, messages_are_found_again_by_their_places) {
  const auto messages = some_messages(60);
  for (const McapBuild& build : test::mcap_builds()) {
    const BuiltRecording file = build_mcap(messages, build);
    EXPECT_EQ(test::expect_by_place(file.bytes, read_mcap, test::words(build)), messages.size());
    for (std::size_t size = 1000; size < file.bytes.size(); size += 331) {
      test::expect_by_place(std::string_view(file.bytes).substr(0, size), read_mcap,
                            test::words(build) + " cut at " + std::to_string(size));
    }
    test::expect_undisturbed_by_places(file.bytes, open_mcap, test::words(build));
    test::expect_other_places_refused(
        file.bytes,
        {build_mcap(some_messages(60, 2), build).bytes, build_mcap(some_messages(5), build).bytes},
        open_mcap);
  }
}

TEST(McapReader, a_chunk_that_says_that_it_is_huge_takes_no_memory) {
  const auto messages = some_messages(7);
  for (const McapBuild& build : test::mcap_builds()) {
    if (!build.has_chunks || build.is_bare_lz4) continue;
    BuiltRecording file = build_mcap(messages, build);
    const std::size_t size = file.parts[0].begin + 9 + 16;
    file.bytes.replace(size, 8, "\xff\xff\xff\xff\xff\xff\xff\x7f");
    Damage damage;
    const auto recording = read_mcap(file.bytes, damage.options());
    EXPECT_EQ(messages_of(*recording), messages) << test::words(build);
    EXPECT_EQ(damage.reasons.size(), 1U) << test::words(build);
  }
}

TEST(McapReader, a_chunk_that_unpacks_to_more_than_is_allowed_is_told) {
  const auto messages = some_messages(14);
  BuiltRecording file = build_mcap(messages, {.packing = Packing::kZstd, .is_closed = false});
  std::string chunk = file.bytes.substr(file.parts[0].begin, 9 + 16 + 8 + 4 + 8);
  const std::string zeroes = test::packed(Packing::kZstd, std::string(200'000'000, '\0'));
  const auto number = [](std::size_t value) {
    std::string bytes(8, '\0');
    for (std::size_t i = 0; i < 8; ++i) bytes[i] = static_cast<char>((value >> (8 * i)) & 0xffU);
    return bytes;
  };
  chunk.replace(1, 8, number(40 + 4 + zeroes.size()));
  file.bytes.insert(file.parts[0].begin, chunk + number(zeroes.size()) + zeroes);
  Damage damage;
  const auto recording = read_mcap(file.bytes, damage.options());
  EXPECT_EQ(messages_of(*recording), messages);
  ASSERT_FALSE(damage.reasons.empty());
  EXPECT_NE(damage.reasons[0].find("unpacks to more than"), std::string::npos) << damage.reasons[0];
}

TEST(McapReader, what_is_no_such_file_is_refused_in_words) {
  EXPECT_TRUE(is_mcap("\x89MCAP0\r\n"));
  EXPECT_FALSE(is_mcap("MCAP0\r\n"));
  EXPECT_FALSE(is_mcap(""));
  for (const char* head : {"\x89MCAP1\r\n", "no such file", ""}) {
    EXPECT_THROW((void)read_mcap(head, {}), DataError) << head;
  }
  EXPECT_THROW((void)open_mcap("/nowhere/at/all.mcap", {}), DataError);
  EXPECT_THROW((void)open_mcap("/tmp", {}), DataError);
}

TEST(McapReader, whoever_wants_no_more_is_asked_within_a_block) {
  test::expect_stops_when_asked(build_mcap(some_messages(600), {.packing = Packing::kZstd}).bytes,
                                read_mcap);
}

TEST(McapReader, a_real_file_holds_as_many_messages_as_others_find_in_it) {
  const std::string path = test::recorded_data("bags/nav2_turtlebot.mcap");
  if (path.empty()) GTEST_SKIP() << "no recorded data";
  Damage damage;
  const auto recording = open_mcap(path, damage.options());
  EXPECT_TRUE(recording->is_indexed());
  std::map<std::string, int> counts;
  while (const auto message = recording->next()) {
    ++counts[recording->topics()[message->topic].name];
  }
  const std::map<std::string, int> expected{
      {"/amcl_pose", 135}, {"/odom", 2639}, {"/tf", 5422}, {"/tf_static", 1}};
  EXPECT_EQ(counts, expected);
  EXPECT_EQ(damage.reasons, std::vector<std::string>{});
  for (const RecordedTopic& topic : recording->topics()) {
    EXPECT_EQ(topic.messages, counts[topic.name]);
    EXPECT_EQ(topic.format, WireFormat::kCdr);
    EXPECT_EQ(topic.definition.language, DefinitionLanguage::kRos2Msg);
    EXPECT_TRUE(topic.hash.starts_with("RIHS01_")) << topic.hash;
  }
}

}  // namespace
}  // namespace loopstone
