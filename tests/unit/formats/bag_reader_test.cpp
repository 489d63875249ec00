#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "chunked_checks.hpp"
#include "formats/recording.hpp"
#include "support/recorded_data.hpp"
#include "support/recording_builder.hpp"
#include "support/recording_damage.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using test::BagBuild;
using test::build_bag;
using test::BuiltMessage;
using test::BuiltRecording;
using test::Damage;
using test::messages_of;
using test::some_messages;

std::vector<BagBuild> builds() {
  std::vector<BagBuild> list;
  for (const Packing packing : {Packing::kNone, Packing::kBzip2, Packing::kLz4}) {
    for (const bool is_indexed : {false, true}) {
      for (const bool outside : {false, true}) {
        list.push_back({.packing = packing,
                        .is_indexed = is_indexed,
                        .outside_of_chunks = outside,
                        .chunk_op_first = outside});
      }
    }
  }
  return list;
}

std::string words(const BagBuild& build) {
  return "packing " + std::to_string(static_cast<int>(build.packing)) +
         (build.is_indexed ? "" : " no index") + (build.outside_of_chunks ? " outside" : "");
}

TEST(BagReader, every_way_to_write_a_bag_gives_the_same_messages) {
  const auto messages = some_messages(60);
  for (const BagBuild& build : builds()) {
    Damage damage;
    const BuiltRecording bag = build_bag(messages, build);
    const auto recording = read_bag(bag.bytes, damage.options());
    EXPECT_EQ(recording->is_indexed(), build.is_indexed);
    EXPECT_EQ(messages_of(*recording), messages);
    EXPECT_EQ(damage.reasons, std::vector<std::string>{});
    EXPECT_EQ(recording->notes().size(), build.is_indexed ? 0 : 1);
    EXPECT_EQ(recording->progress().bytes_total, static_cast<std::int64_t>(bag.bytes.size()));
    recording->rewind();
    EXPECT_EQ(messages_of(*recording), messages);
  }
}

TEST(BagReader, topics_say_type_definition_and_count) {
  const auto messages = some_messages(60);
  const BuiltRecording bag = build_bag(messages, {.packing = Packing::kLz4});
  const auto recording = read_bag(bag.bytes, {});
  ASSERT_EQ(recording->topics().size(), 3U);
  std::map<std::string, std::int64_t> counts;
  for (const BuiltMessage& message : messages) ++counts[message.topic];
  for (std::size_t i = 0; i < 3; ++i) {
    const RecordedTopic& topic = recording->topics()[i];
    EXPECT_EQ(topic.name, test::built_topics()[i].name);
    EXPECT_EQ(topic.type, test::built_topics()[i].type);
    EXPECT_EQ(topic.definition.text, test::built_topics()[i].definition);
    EXPECT_EQ(topic.definition.language, DefinitionLanguage::kRos1Msg);
    EXPECT_EQ(topic.format, WireFormat::kRos1);
    EXPECT_EQ(topic.hash, "0123");
    EXPECT_EQ(topic.unreadable, "");
    EXPECT_EQ(topic.messages, counts[topic.name]);
  }
}

TEST(BagReader, a_file_gives_what_memory_gives_and_says_where) {
  const auto messages = some_messages(60);
  const BuiltRecording bag = build_bag(messages, {});
  const test::TempDir dir;
  const auto recording = open_bag(dir.write("a.bag", bag.bytes), {});
  std::size_t i = 0;
  while (const auto message = recording->next()) {
    const Location where = message->where();
    EXPECT_EQ(where.path, dir / "a.bag");
    // Of chunks that are not packed it is the message's own record.
    const auto at = static_cast<std::size_t>(*where.byte_offset);
    EXPECT_NE(bag.bytes.substr(at, 400).find(messages[i].bytes.substr(0, 12)), std::string::npos);
    ++i;
  }
  EXPECT_EQ(i, messages.size());
}

TEST(BagReader, only_wanted_topics_are_given_and_chunks_without_them_are_not_unpacked) {
  auto messages = some_messages(60);
  for (std::size_t i = 0; i < messages.size(); ++i)
    messages[i].topic = i / 7 == 3 ? "/scan" : "/tf";
  for (BagBuild build : builds()) {
    if (build.outside_of_chunks) continue;
    BuiltRecording bag = build_bag(messages, build);
    // Only a chunk that is looked into tells that it is damaged.
    const auto& spoiled = bag.parts[5];
    std::fill(bag.bytes.begin() + static_cast<long>((spoiled.begin + spoiled.end) / 2),
              bag.bytes.begin() + static_cast<long>(spoiled.end), 'x');
    Damage damage;
    const auto recording = read_bag(bag.bytes, damage.options());
    recording->want([](const RecordedTopic& topic) { return topic.name == "/scan"; });
    const std::vector<BuiltMessage> expected(messages.begin() + 21, messages.begin() + 28);
    EXPECT_EQ(messages_of(*recording), expected);
    EXPECT_EQ(damage.reasons.empty(), build.is_indexed);
    recording->want({});
    recording->rewind();
    EXPECT_GT(messages_of(*recording).size(), 50U);
    EXPECT_FALSE(damage.reasons.empty());
  }
}

TEST(BagReader, a_bag_that_is_cut_anywhere_gives_the_messages_before) {
  const auto messages = some_messages(30);
  for (const BagBuild& build : builds()) {
    test::expect_what_is_before_cuts(build_bag(messages, build), messages, 13, 7, read_bag,
                                     words(build));
  }
}

TEST(BagReader, a_chunk_that_is_cut_gives_what_is_in_it) {
  const auto messages = some_messages(100);
  for (const Packing packing : {Packing::kNone, Packing::kLz4}) {
    const BuiltRecording bag = build_bag(messages, {.packing = packing, .per_chunk = 100});
    const std::size_t half = (bag.parts[0].begin + bag.parts[0].end) / 2;
    Damage damage;
    const auto recording = read_bag(std::string_view(bag.bytes).substr(0, half), damage.options());
    const auto got = messages_of(*recording);
    EXPECT_GT(got.size(), 30U);
    EXPECT_LT(got.size(), 70U);
    ASSERT_EQ(damage.reasons.size(), 1U);
    EXPECT_NE(damage.reasons[0].find("ends too early"), std::string::npos) << damage.reasons[0];
    recording->rewind();
    EXPECT_EQ(messages_of(*recording), got);
    EXPECT_EQ(damage.reasons.size(), 1U);  // it is told once
  }
}

TEST(BagReader, wrong_lengths_of_index_records_and_junk_before_the_index_cost_nothing) {
  const auto messages = some_messages(60);
  for (const Packing packing : {Packing::kNone, Packing::kBzip2, Packing::kLz4}) {
    const BuiltRecording bag = build_bag(
        messages, {.packing = packing, .has_wrong_index_lengths = true, .junk_before_index = 3000});
    Damage damage;
    const auto recording = read_bag(bag.bytes, damage.options());
    EXPECT_EQ(messages_of(*recording), messages);
    EXPECT_EQ(damage.reasons, std::vector<std::string>{});
    EXPECT_EQ(recording->notes().size(), 2U);
  }
}

TEST(BagReader, what_is_undamaged_is_found_wherever_the_damage_is) {
  const auto messages = some_messages(60);
  const auto variants = builds();
  std::size_t placed = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    const BagBuild& build = variants[seed % variants.size()];
    const auto spoiled = test::damaged(build_bag(messages, build), messages.size(), seed);
    const std::string what = words(build) + ", seed " + std::to_string(seed);
    test::expect_what_is_undamaged(spoiled, messages, read_bag, what);
    placed += test::expect_by_place(spoiled.bytes, read_bag, what);
  }
  EXPECT_GT(placed, 500 * messages.size() / 2);
}

TEST(BagReader, messages_are_found_again_by_their_places) {
  const auto messages = some_messages(60);
  for (const BagBuild& build : builds()) {
    const BuiltRecording bag = build_bag(messages, build);
    EXPECT_EQ(test::expect_by_place(bag.bytes, read_bag, words(build)), messages.size());
    for (std::size_t size = 1000; size < bag.bytes.size(); size += 97) {
      test::expect_by_place(std::string_view(bag.bytes).substr(0, size), read_bag,
                            words(build) + " cut at " + std::to_string(size));
    }
    test::expect_undisturbed_by_places(bag.bytes, open_bag, words(build));
    test::expect_other_places_refused(
        bag.bytes,
        {build_bag(some_messages(60, 2), build).bytes, build_bag(some_messages(5), build).bytes},
        open_bag);
  }
}

TEST(BagReader, a_chunk_that_says_that_it_is_huge_takes_no_memory) {
  BuiltRecording bag = build_bag(some_messages(7), {.packing = Packing::kLz4});
  const std::size_t size = bag.bytes.find("size=", bag.parts[0].begin);
  bag.bytes.replace(size + 5, 4, "\xff\xff\xff\xff");
  const auto recording = read_bag(bag.bytes, {});
  EXPECT_EQ(messages_of(*recording).size(), 7U);
}

TEST(BagReader, a_chunk_that_unpacks_to_more_than_is_allowed_is_told) {
  const std::string zeroes = test::packed(Packing::kBzip2, std::string(200'000'000, '\0'));
  const auto messages = some_messages(7);
  BuiltRecording bag = build_bag(messages, {.packing = Packing::kBzip2, .is_indexed = false});
  std::string head = bag.bytes.substr(bag.parts[0].begin, 200);
  head.resize(head.find("BZh"));
  head.replace(
      head.size() - 4, 4,
      {static_cast<char>(zeroes.size() & 0xffU), static_cast<char>(zeroes.size() >> 8U), 0, 0});
  bag.bytes.insert(bag.parts[0].begin, head + zeroes);
  Damage damage;
  const auto recording = read_bag(bag.bytes, damage.options());
  EXPECT_EQ(messages_of(*recording), messages);
  ASSERT_FALSE(damage.reasons.empty());
  EXPECT_NE(damage.reasons[0].find("unpacks to more than"), std::string::npos) << damage.reasons[0];
}

TEST(BagReader, what_is_no_bag_is_refused_in_words) {
  EXPECT_TRUE(is_bag("#ROSBAG V2.0\n"));
  EXPECT_TRUE(is_bag("#ROSBAG V1.2\n"));
  EXPECT_FALSE(is_bag("PARAM robot_frontlaser_offset"));
  EXPECT_FALSE(is_bag(""));
  for (const char* head : {"#ROSBAG V1.2\n", "#ROSBAG V3.0\n", "no bag at all", ""}) {
    EXPECT_THROW((void)read_bag(head, {}), DataError) << head;
  }
  EXPECT_THROW((void)open_bag("/nowhere/at/all.bag", {}), DataError);
  EXPECT_THROW((void)open_bag("/tmp", {}), DataError);
}

TEST(BagReader, whoever_wants_no_more_is_asked_within_a_block) {
  test::expect_stops_when_asked(build_bag(some_messages(60), {.packing = Packing::kBzip2}).bytes,
                                read_bag);
}

struct RealBag {
  const char* name;
  std::map<std::string, int> counts;
};

TEST(BagReader, real_bags_hold_as_many_messages_as_others_find_in_them) {
  const std::vector<RealBag> bags{
      {"b0-2014-07-21-12-42-53-short.bag",
       {{"horizontal_laser_2d", 345}, {"imu", 1974}, {"vertical_laser_2d", 385}}},
      {"guardian_3.bag",
       {{"/diagnostics", 713},
        {"/guardian_node/command", 7815},
        {"/guardian_node/odom", 2079},
        {"/guardian_node/state", 2079},
        {"/hokuyo/parameter_descriptions", 1},
        {"/hokuyo/parameter_updates", 1},
        {"/hokuyo_back/parameter_descriptions", 1},
        {"/hokuyo_back/parameter_updates", 1},
        {"/hokuyo_back_scan", 1038},
        {"/joint_states", 7287},
        {"/joy", 7829},
        {"/rly_08_node/status", 1040},
        {"/rosout", 19},
        {"/scan", 1036},
        {"/tf", 22998}}},
      {"guardian_controller_2.bag",
       {{"/controller_state", 1027},
        {"/diagnostics", 704},
        {"/guardian_node/command", 1028},
        {"/guardian_node/odom", 2060},
        {"/guardian_node/state", 2060},
        {"/hokuyo/parameter_descriptions", 1},
        {"/hokuyo/parameter_updates", 1},
        {"/hokuyo_back/parameter_descriptions", 1},
        {"/hokuyo_back/parameter_updates", 1},
        {"/hokuyo_back_scan", 1031},
        {"/joint_states", 7201},
        {"/pose_goal", 2},
        {"/rly_08_node/status", 1030},
        {"/rosout", 4121},
        {"/rosout_agg", 4103},
        {"/scan", 1028},
        {"/tf", 44254},
        {"/trajectory", 104}}},
      {"laser_scan_matcher_demo.bag", {{"/scan", 360}}},  // as its index says
      {"office_2019.bag", {{"/cmd_vel", 72}, {"/odom", 862}, {"/scan", 859}, {"/tf", 861}}},
      {"office_col.bag", {{"/cmd_vel", 856}, {"/odom", 1010}, {"/scan", 920}, {"/tf", 3261}}},
      {"office_jumping_tf.bag", {{"/cmd_vel", 514}, {"/odom", 516}, {"/scan", 514}, {"/tf", 2630}}},
      {"tf_example.bag", {{"/tf", 517}, {"/tf_static", 1}}},
      {"trace0.bag", {{"/base_scan", 958}, {"/odom", 958}, {"/tf", 2876}}},
  };
  for (const RealBag& bag : bags) {
    const std::string path = test::recorded_data(std::string("bags/") + bag.name);
    if (path.empty()) GTEST_SKIP() << "no recorded data";
    Damage damage;
    const auto recording = open_bag(path, damage.options());
    EXPECT_TRUE(recording->is_indexed()) << bag.name;
    std::map<std::string, int> counts;
    while (const auto message = recording->next())
      ++counts[recording->topics()[message->topic].name];
    EXPECT_EQ(counts, bag.counts) << bag.name;
    EXPECT_EQ(damage.reasons, std::vector<std::string>{}) << bag.name;
  }
}

}  // namespace
}  // namespace loopstone
