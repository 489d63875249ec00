#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <functional>
#include <string>

#include "base/crc32.hpp"
#include "formats/recording.hpp"
#include "formats/recording_writer.hpp"
#include "formats/rosbag2_metadata.hpp"
#include "loopstone/base/error.hpp"
#include "recording_samples.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;
using test::message_bytes;
using test::read_messages;
using test::string_topic;
using test::TempDir;
using test::TestDatabase;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

using Create = std::unique_ptr<RecordingWriter> (*)(const std::string&);

using Open = std::unique_ptr<Recording> (*)(const std::string&, const RecordingOptions&);

struct Container {
  const char* name;
  const char* file;  ///< that its writer is given
  Create create;
  Open open;
};

constexpr Container kContainers[] = {{"mcap", "a.mcap", create_mcap, open_mcap},
                                     {"bag", "a.bag", create_bag, open_bag},
                                     {"rosbag2", "a", create_rosbag2, open_rosbag2}};

class RecordingWriters : public testing::TestWithParam<Container> {
 protected:
  [[nodiscard]] std::unique_ptr<RecordingWriter> create() const {
    return GetParam().create(path());
  }
  [[nodiscard]] std::string path() const { return dir_ / GetParam().file; }
  /// Of all that was written.
  [[nodiscard]] std::string bytes() const {
    std::string all;
    for (const auto& entry : fs::recursive_directory_iterator(dir_.path())) {
      if (entry.is_regular_file()) all += dir_.read(fs::relative(entry.path(), dir_.path()));
    }
    return all;
  }

  TempDir dir_;
};

INSTANTIATE_TEST_SUITE_P(All, RecordingWriters, testing::ValuesIn(kContainers),
                         [](const auto& made) { return std::string(made.param.name); });

/// Two topics with messages, one without, the messages of some chunks and not in order.
void write_sample(RecordingWriter& writer, int messages = 400, std::size_t size = 5000) {
  const auto a = writer.add_topic(string_topic("/a"));
  const auto b = writer.add_topic(string_topic("/b", true));
  (void)writer.add_topic(string_topic("/silent"));
  for (int i = 0; i < messages; ++i) {
    const std::string bytes = message_bytes(i, size);
    writer.write(i % 3 == 0 ? b : a, {1'000'000'000LL + 1000 * (i ^ 1)}, bytes);
  }
}

TEST_P(RecordingWriters, NothingAppearsBeforeTheEnd) {
  {
    const auto writer = create();
    write_sample(*writer);
    EXPECT_FALSE(fs::exists(path()));
    EXPECT_EQ(dir_.names().size(), 1U) << "one hidden name";
  }
  EXPECT_THAT(dir_.names(), IsEmpty()) << "what was begun stayed";
  const auto writer = create();
  write_sample(*writer);
  writer->finish();
  EXPECT_THAT(dir_.names(), ElementsAre(GetParam().file));
}

TEST_P(RecordingWriters, TheSameBytesEveryTime) {
  std::string first;
  for (int i = 0; i < 2; ++i) {
    const auto writer = create();
    write_sample(*writer);
    writer->finish();
    if (i == 0) first = bytes();
  }
  EXPECT_GT(first.size(), 1000U);
  EXPECT_TRUE(bytes() == first);
  EXPECT_THAT(dir_.names(), ElementsAre(GetParam().file)) << "the earlier one gave way";
}

TEST_P(RecordingWriters, FullDiskLeavesNothing) {
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  for (const rlim_t most : {20'000U, 120'000U}) {
    rlimit small = before;
    small.rlim_cur = most;
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    std::string refusal = "none";
    try {
      const auto writer = create();
      const auto topic = writer->add_topic(string_topic("/a"));
      for (int i = 0; i < 300; ++i) {
        std::string noise(20'000, '\0');
        std::uint32_t state = static_cast<std::uint32_t>(i) * 7919U + 1U;
        for (char& c : noise) c = static_cast<char>((state = state * 1664525U + 1013904223U) >> 24);
        writer->write(topic, {i}, noise);
      }
      writer->finish();
    } catch (const DataError& error) {
      refusal = error.what();
    }
    ::setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_THAT(refusal, HasSubstr(GetParam().file));
    EXPECT_THAT(dir_.names(), IsEmpty());
  }
  std::signal(SIGXFSZ, old_handler);
}

TEST_P(RecordingWriters, NoPlaceForIt) {
  EXPECT_THROW((void)GetParam().create(dir_ / "none/a"), DataError);
  fs::create_directory(dir_ / "full");
  dir_.write("full/precious.txt", "x");
  EXPECT_THROW((void)GetParam().create(dir_ / "full"), DataError);
  EXPECT_EQ(dir_.read("full/precious.txt"), "x");
}

TEST_P(RecordingWriters, NoTimesBeforeZero) {
  const auto writer = create();
  const auto topic = writer->add_topic(string_topic("/a"));
  EXPECT_THROW(writer->write(topic, {-1}, message_bytes(1)), DataError);
}

TEST_P(RecordingWriters, SayWhatTheyTake) {
  const bool is_bag = std::string(GetParam().name) == "bag";
  EXPECT_EQ(create()->wire_format(), is_bag ? WireFormat::kRos1 : WireFormat::kCdr);
}

TEST_P(RecordingWriters, WhatIsWrittenIsRead) {
  constexpr std::size_t kHuge = 3'000'000;
  {
    const auto writer = create();
    write_sample(*writer);
    writer->write(0, {2'000'000'000}, message_bytes(1000, kHuge));
    writer->write(1, {3'000'000'000}, {});
    writer->finish();
  }
  RecordingOptions options;
  options.on_damage = [](const Problem& problem) { ADD_FAILURE() << problem.reason; };
  const auto recording = GetParam().open(path(), options);
  EXPECT_TRUE(recording->is_indexed());
  ASSERT_EQ(recording->topics().size(), 3U) << "also the one without messages";
  for (const RecordedTopic& topic : recording->topics()) {
    EXPECT_EQ(topic.type, "std_msgs/String");
    EXPECT_THAT(topic.definition.text, HasSubstr("string data"));
    const bool is_bag = recording->topics()[0].format == WireFormat::kRos1;
    EXPECT_EQ(topic.hash, is_bag ? string_topic("").md5 : string_topic("").rihs01);
  }
  auto messages = read_messages(*recording);
  std::stable_sort(messages.begin(), messages.end(),
                   [](const auto& a, const auto& b) { return a.time_ns < b.time_ns; });
  ASSERT_EQ(messages.size(), 402U);
  for (std::int64_t i = 0; i < 400; ++i) {
    const auto& message = messages[static_cast<std::size_t>(i)];
    EXPECT_EQ(message.time_ns, 1'000'000'000 + 1000 * i);
    EXPECT_EQ(message.bytes, message_bytes(i ^ 1, 5000));
    EXPECT_EQ(message.topic, (i ^ 1) % 3 == 0 ? "/b" : "/a");
  }
  EXPECT_TRUE(messages[400].bytes == message_bytes(1000, kHuge));
  EXPECT_TRUE(messages[401].bytes.empty());
  EXPECT_THAT(recording->notes(), IsEmpty());
}

// rosbag2

TEST(Rosbag2Writer, IsReadBack) {
  const TempDir dir;
  {
    const auto writer = create_rosbag2(dir / "run/");
    write_sample(*writer);
    writer->finish();
  }
  EXPECT_TRUE(fs::exists(dir / "run/run_0.db3"));
  EXPECT_THAT(rosbag2_files(dir / "run"), ElementsAre(dir / "run/run_0.db3"));
  RecordingOptions options;
  options.on_damage = [](const Problem& problem) { ADD_FAILURE() << problem.reason; };
  const auto recording = open_rosbag2(dir / "run", options);
  const auto& topics = recording->topics();
  ASSERT_EQ(topics.size(), 3U);
  EXPECT_EQ(topics[0].type, "std_msgs/String");
  EXPECT_EQ(topics[0].hash, string_topic("").rihs01);
  EXPECT_EQ(topics[0].definition.text, "string data");
  EXPECT_EQ(topics[0].messages, 266);
  EXPECT_EQ(topics[2].messages, 0);
  EXPECT_THAT(recording->notes(), IsEmpty());
  const auto messages = read_messages(*recording);
  ASSERT_EQ(messages.size(), 400U);
  for (std::int64_t i = 0; i < 400; ++i) {
    const auto& message = messages[static_cast<std::size_t>(i)];
    EXPECT_EQ(message.time_ns, 1'000'000'000 + 1000 * i) << "by time";
    EXPECT_EQ(message.bytes, message_bytes(i ^ 1, 5000));
    EXPECT_EQ(message.topic, (i ^ 1) % 3 == 0 ? "/b" : "/a");
  }
}

TEST(Rosbag2Writer, TablesAndMetadata) {
  const TempDir dir;
  {
    const auto writer = create_rosbag2(dir / "run");
    write_sample(*writer, 10, 40);
    writer->finish();
  }
  TestDatabase database(dir / "run/run_0.db3");
  EXPECT_EQ(database.number("SELECT schema_version FROM schema"), 4);
  EXPECT_EQ(database.number("SELECT metadata_version FROM metadata"), 9);
  EXPECT_EQ(database.number("SELECT count(*) FROM message_definitions"), 1);
  EXPECT_EQ(database.number("SELECT count(*) FROM sqlite_master WHERE name='timestamp_idx'"), 1);
  EXPECT_EQ(database.number("SELECT count(*) FROM topics WHERE type='std_msgs/msg/String'"), 3);
  EXPECT_EQ(database.number("SELECT id FROM topics WHERE offered_qos_profiles LIKE "
                            "'%reliability: reliable%durability: transient_local%'"),
            2);
  const std::string text = dir.read("run/metadata.yaml");
  const Rosbag2Metadata metadata = parse_rosbag2_metadata(text);
  EXPECT_EQ(metadata.version, 9);
  EXPECT_EQ(metadata.storage, "sqlite3");
  EXPECT_THAT(text, HasSubstr("  message_count: 10\n"));
  EXPECT_THAT(text, HasSubstr("nanoseconds_since_epoch: 1000000000\n"));
  EXPECT_THAT(text, HasSubstr("    nanoseconds: 9000\n"));
}

TEST(Rosbag2Writer, GivesNoOtherFolderAway) {
  const TempDir dir;
  fs::create_directory(dir / "empty");
  {
    const auto writer = create_rosbag2(dir / "empty");
    writer->finish();
  }
  EXPECT_TRUE(fs::exists(dir / "empty/metadata.yaml"));
  const auto writer = create_rosbag2(dir / "empty");
  dir.write("empty/precious.txt", "x");
  EXPECT_THROW(writer->finish(), DataError);
  EXPECT_EQ(dir.read("empty/precious.txt"), "x");
  EXPECT_TRUE(fs::exists(dir / "empty/metadata.yaml"));
  dir.write("file", "x");
  EXPECT_THROW((void)create_rosbag2(dir / "file"), DataError);
  EXPECT_THROW((void)create_rosbag2(""), UsageError);
  EXPECT_THROW((void)create_rosbag2(".."), UsageError);
}

// MCAP, record by record

template <typename T>
T little_endian(std::string_view bytes, std::size_t at) {
  T value{};
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

struct McapRecord {
  int op = 0;
  std::size_t offset = 0;
  std::string_view content{};
};

std::vector<McapRecord> mcap_records(std::string_view bytes) {
  constexpr std::size_t kMagic = 8;
  std::vector<McapRecord> records;
  for (std::size_t at = kMagic; at + kMagic < bytes.size();) {
    const auto size = little_endian<std::uint64_t>(bytes, at + 1);
    records.push_back({static_cast<unsigned char>(bytes[at]), at, bytes.substr(at + 9, size)});
    at += 9 + size;
  }
  return records;
}

std::vector<McapRecord> of(const std::vector<McapRecord>& records, int op) {
  std::vector<McapRecord> found;
  for (const McapRecord& record : records) {
    if (record.op == op) found.push_back(record);
  }
  return found;
}

constexpr int kFooter = 2;
constexpr int kChannel = 4;
constexpr int kChunk = 6;
constexpr int kMessageIndex = 7;
constexpr int kChunkIndex = 8;
constexpr int kStatistics = 11;
constexpr int kDataEnd = 15;

TEST(McapWriter, EveryChunkIsIndexedAndNoneIsEmpty) {
  for (const std::size_t size : {std::size_t{40}, std::size_t{5000}, std::size_t{3'000'000}}) {
    const TempDir dir;
    const auto writer = create_mcap(dir / "a.mcap");
    write_sample(*writer, size > 1'000'000 ? 3 : 400, size);
    writer->finish();
    const std::string bytes = dir.read("a.mcap");
    const auto records = mcap_records(bytes);
    const auto chunks = of(records, kChunk);
    const auto indexes = of(records, kChunkIndex);
    ASSERT_EQ(chunks.size(), indexes.size());
    EXPECT_EQ(chunks.size(), size > 1'000'000 ? 3U : size == 40 ? 1U : 3U);
    EXPECT_GE(of(records, kMessageIndex).size(), chunks.size());
    for (std::size_t i = 0; i < chunks.size(); ++i) {
      EXPECT_GT(little_endian<std::uint64_t>(chunks[i].content, 16), size);
      EXPECT_NE(little_endian<std::uint32_t>(chunks[i].content, 24), 0U) << "its checksum";
      EXPECT_EQ(little_endian<std::uint64_t>(indexes[i].content, 16), chunks[i].offset);
      EXPECT_EQ(little_endian<std::uint64_t>(indexes[i].content, 24), 9 + chunks[i].content.size());
    }
  }
}

TEST(McapWriter, ChecksumsAndOffsetsHold) {
  const TempDir dir;
  const auto writer = create_mcap(dir / "a.mcap");
  write_sample(*writer);
  writer->finish();
  const std::string bytes = dir.read("a.mcap");
  EXPECT_TRUE(bytes.starts_with("\x89MCAP0\r\n"));
  EXPECT_TRUE(bytes.ends_with("\x89MCAP0\r\n"));
  const auto records = mcap_records(bytes);
  const auto data_end = of(records, kDataEnd);
  ASSERT_EQ(data_end.size(), 1U);
  EXPECT_EQ(little_endian<std::uint32_t>(data_end[0].content, 0),
            crc32_of(std::string_view(bytes).substr(0, data_end[0].offset)));
  const McapRecord footer = records.back();
  ASSERT_EQ(footer.op, kFooter);
  const auto summary = little_endian<std::uint64_t>(footer.content, 0);
  EXPECT_EQ(summary, data_end[0].offset + 13);
  EXPECT_EQ(little_endian<std::uint32_t>(footer.content, 16),
            crc32_of(std::string_view(bytes).substr(summary, footer.offset + 9 + 16 - summary)));
  const auto statistics = of(records, kStatistics);
  ASSERT_EQ(statistics.size(), 1U);
  EXPECT_EQ(little_endian<std::uint64_t>(statistics[0].content, 0), 400U);
  EXPECT_EQ(little_endian<std::uint64_t>(statistics[0].content, 26), 1'000'000'000U);
  EXPECT_EQ(little_endian<std::uint64_t>(statistics[0].content, 34), 1'000'399'000U);
}

TEST(McapWriter, TopicsWithoutMessagesAreThere) {
  const TempDir dir;
  const auto writer = create_mcap(dir / "a.mcap");
  (void)writer->add_topic(string_topic("/silent", true));
  writer->finish();
  const auto bytes = dir.read("a.mcap");
  const auto records = mcap_records(bytes);
  EXPECT_THAT(of(records, kChunk), IsEmpty());
  const auto channels = of(records, kChannel);
  ASSERT_EQ(channels.size(), 2U) << "among the data and in the summary";
  EXPECT_THAT(std::string(channels[0].content), HasSubstr("durability: transient_local"));
  EXPECT_THAT(std::string(channels[0].content), HasSubstr("topic_type_hash"));
}

// Bags, part by part

TEST(BagWriter, HeadAndChunksAreAsRosbagInsists) {
  const TempDir dir;
  const auto writer = create_bag(dir / "a.bag");
  write_sample(*writer);
  writer->finish();
  const std::string bytes = dir.read("a.bag");
  constexpr std::size_t kLine = 13;
  EXPECT_EQ(bytes.substr(0, kLine), "#ROSBAG V2.0\n");
  const auto header = little_endian<std::uint32_t>(bytes, kLine);
  const auto padding = little_endian<std::uint32_t>(bytes, kLine + 4 + header);
  EXPECT_EQ(4 + header + 4 + padding, 4096U);
  const std::size_t name = bytes.find("index_pos=");
  ASSERT_LT(name, 4096U);
  const auto index = little_endian<std::uint64_t>(bytes, name + 10);
  ASSERT_LT(index, bytes.size());
  EXPECT_NE(bytes.find("topic=/silent", index), bytes.npos);
  EXPECT_NE(bytes.find("latching=1", index), bytes.npos);
  EXPECT_NE(bytes.find("md5sum=992ce8a1687cec8c8bd883ec73ca41d1", index), bytes.npos);
  EXPECT_EQ(little_endian<std::uint32_t>(bytes, bytes.find("conn_count=") + 11), 3U);
  EXPECT_EQ(little_endian<std::uint32_t>(bytes, bytes.find("chunk_count=") + 12), 3U);
  const std::size_t frame = bytes.find("\x04\x22\x4D\x18");
  ASSERT_NE(frame, bytes.npos);
  const auto flags = static_cast<unsigned char>(bytes[frame + 4]);
  EXPECT_EQ(flags, 0x64) << "version 1, independent blocks, a checksum of the whole and no more";
}

TEST(BagWriter, NoTimesAfter2106) {
  const TempDir dir;
  const auto writer = create_bag(dir / "a.bag");
  const auto topic = writer->add_topic(string_topic("/a"));
  writer->write(topic, {4'294'967'295'999'999'999}, message_bytes(1));
  EXPECT_THROW(writer->write(topic, {4'294'967'296'000'000'000}, message_bytes(1)), DataError);
}

}  // namespace
}  // namespace loopstone
