#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <numeric>
#include <set>
#include <string>

#include "formats/recording.hpp"
#include "formats/rosbag2_folder.hpp"
#include "formats/rosbag2_metadata.hpp"
#include "loopstone/base/error.hpp"
#include "recording_samples.hpp"
#include "support/placed_messages.hpp"
#include "support/recording_builder.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;
using test::add_topic;
using test::make_tables;
using test::message_bytes;
using test::numbers_of;
using test::read_messages;
using test::TempDir;
using test::TestDatabase;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A recording that is read, with what it tells.
struct Reading {
  std::vector<std::string> damage{};
  std::unique_ptr<Recording> recording{};
  std::vector<test::ReadMessage> messages{};
};

RecordingOptions telling(std::vector<std::string>& damage) {
  RecordingOptions options;
  options.on_damage = [&damage](const Problem& problem) {
    damage.push_back(to_string(problem.location) + ": " + problem.reason);
  };
  return options;
}

Reading read(const std::string& path) {
  Reading reading;
  reading.recording = open_rosbag2(path, telling(reading.damage));
  reading.messages = read_messages(*reading.recording);
  return reading;
}

std::string refusal_of(const std::string& path) {
  try {
    (void)open_rosbag2(path, {});
  } catch (const DataError& error) {
    return error.what();
  }
  return "none";
}

/// Messages numbered from `first`, every other of "/a" and "/b", one a microsecond.
void fill(TestDatabase& database, std::int64_t first, std::int64_t count, std::size_t size = 40) {
  database.run("BEGIN");
  for (std::int64_t i = first; i < first + count; ++i) {
    database.add_message(1 + i % 2, 1000 * i, message_bytes(i, size));
  }
  database.run("COMMIT");
}

void make_log(const std::string& path, std::int64_t first, std::int64_t count, int version = 4,
              std::size_t size = 40, bool with_index = true) {
  TestDatabase database(path);
  make_tables(database, version, with_index);
  add_topic(database, "/a", "std_msgs/msg/String", version);
  add_topic(database, "/b", "sensor_msgs/msg/LaserScan", version);
  fill(database, first, count, size);
}

std::vector<std::int64_t> range(std::int64_t first, std::int64_t count) {
  std::vector<std::int64_t> numbers(static_cast<std::size_t>(count));
  std::iota(numbers.begin(), numbers.end(), first);
  return numbers;
}

std::string metadata_for(const std::vector<std::string>& files, const std::string& more = "") {
  std::string text =
      "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n"
      "  relative_file_paths:\n";
  for (const std::string& file : files) text += "    - " + file + "\n";
  return text + more;
}

/// Names of everything in the machine's folder for temporary files that is ours.
std::set<std::string> temporary_folders() {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(fs::temp_directory_path())) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("loopstone-") && !name.starts_with("loopstone-test-")) names.insert(name);
  }
  return names;
}

TEST(Rosbag2Reader, EveryVersionOfTheTables) {
  for (const int version : {1, 2, 3, 4}) {
    const TempDir dir;
    make_log(dir / "a.db3", 0, 10, version);
    const Reading reading = read(dir / "a.db3");
    EXPECT_EQ(numbers_of(reading.messages), range(0, 10)) << version;
    EXPECT_THAT(reading.damage, IsEmpty());
    const auto& topics = reading.recording->topics();
    ASSERT_EQ(topics.size(), 2U);
    EXPECT_EQ(topics[0].name, "/a");
    EXPECT_EQ(topics[1].type, "sensor_msgs/LaserScan");
    EXPECT_EQ(topics[0].format, WireFormat::kCdr);
    EXPECT_EQ(topics[0].hash, version >= 4 ? "RIHS01_of_/a" : "");
    EXPECT_TRUE(reading.recording->is_indexed());
    EXPECT_EQ(reading.messages[3].topic, "/b");
    EXPECT_EQ(reading.messages[3].time_ns, 3000);
    EXPECT_EQ(dir.names(), std::vector<std::string>{"a.db3"}) << "something was left beside it";
  }
}

TEST(Rosbag2Reader, MessagesComeByTime) {
  const TempDir dir;
  {
    TestDatabase database(dir / "a.db3");
    make_tables(database);
    add_topic(database, "/a", "std_msgs/msg/String");
    for (const int i : {5, 3, 9, 1, 3}) database.add_message(1, i, message_bytes(i));
  }
  EXPECT_THAT(numbers_of(read(dir / "a.db3").messages), ElementsAre(1, 3, 3, 5, 9));
  {
    TestDatabase database(dir / "a.db3");
    database.run("DROP INDEX timestamp_idx");
  }
  const Reading unindexed = read(dir / "a.db3");
  EXPECT_THAT(numbers_of(unindexed.messages), ElementsAre(5, 3, 9, 1, 3));
  EXPECT_THAT(unindexed.damage, IsEmpty());
}

TEST(Rosbag2Reader, DefinitionsOfTheirTypes) {
  const TempDir dir;
  {
    TestDatabase database(dir / "a.db3");
    make_tables(database);
    add_topic(database, "/a", "std_msgs/msg/String");
    add_topic(database, "/b", "x_msgs/msg/Y");
    add_topic(database, "/c", "std_msgs/msg/String", 4, "protobuf");
    add_topic(database, "/d", "tf/tfMessage", 4, "ros1");
    database.run(
        "INSERT INTO message_definitions VALUES "
        "(1,'std_msgs/msg/String','ros2msg','string other','RIHS01_other'),"
        "(2,'std_msgs/msg/String','ros2msg','string data','RIHS01_of_/a'),"
        "(3,'x_msgs/msg/Y','ros2idl','struct Y','')");
  }
  const auto recording = open_rosbag2(dir / "a.db3", {});
  const auto& topics = recording->topics();
  ASSERT_EQ(topics.size(), 4U);
  EXPECT_EQ(topics[0].definition.text, "string data");
  EXPECT_EQ(topics[0].definition.language, DefinitionLanguage::kRos2Msg);
  EXPECT_EQ(topics[1].definition.language, DefinitionLanguage::kRos2Idl);
  EXPECT_EQ(topics[0].unreadable, "");
  EXPECT_EQ(topics[2].unreadable, "encoded as protobuf");
  EXPECT_EQ(topics[3].format, WireFormat::kRos1);
  EXPECT_EQ(topics[3].type, "tf2_msgs/TFMessage");
}

TEST(Rosbag2Reader, OnlyWhatIsWanted) {
  const TempDir dir;
  make_log(dir / "a.db3", 0, 10);
  const auto recording = open_rosbag2(dir / "a.db3", {});
  int asked = 0;
  recording->want([&asked](const RecordedTopic& topic) {
    ++asked;
    return topic.name == "/b";
  });
  EXPECT_THAT(numbers_of(read_messages(*recording)), ElementsAre(1, 3, 5, 7, 9));
  EXPECT_EQ(asked, 2);
  recording->rewind();
  EXPECT_EQ(read_messages(*recording).size(), 5U);
  recording->want({});
  recording->rewind();
  EXPECT_EQ(read_messages(*recording).size(), 10U);
  recording->want([](const RecordedTopic&) { return false; });
  recording->rewind();
  EXPECT_THAT(read_messages(*recording), IsEmpty());
}

TEST(Rosbag2Reader, ChangesItsMindInTheMiddle) {
  const TempDir dir;
  make_log(dir / "a.db3", 0, 10);
  const auto recording = open_rosbag2(dir / "a.db3", {});
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(recording->next());
  recording->want([](const RecordedTopic& topic) { return topic.name == "/a"; });
  EXPECT_THAT(numbers_of(read_messages(*recording)), ElementsAre(4, 6, 8));
}

TEST(Rosbag2Reader, TellsWhereAndHowFar) {
  const TempDir dir;
  make_log(dir / "a.db3", 0, 10);
  const auto recording = open_rosbag2(dir / "a.db3", {});
  const auto size = static_cast<std::int64_t>(fs::file_size(dir / "a.db3"));
  EXPECT_EQ(recording->progress().bytes_done, 0);
  EXPECT_EQ(recording->progress().bytes_total, size);
  auto message = recording->next();
  message = recording->next();
  ASSERT_TRUE(message);
  EXPECT_EQ(to_string(message->where()), dir / "a.db3" + " (message 2)");
  EXPECT_NEAR(static_cast<double>(recording->progress().bytes_done),
              0.2 * static_cast<double>(size), 2.0);
  while (recording->next()) {
  }
  EXPECT_EQ(recording->progress().bytes_done, size);
}

TEST(Rosbag2Reader, StopsWhenAsked) {
  const TempDir dir;
  make_log(dir / "a.db3", 0, 1000);
  bool stops = false;
  RecordingOptions options;
  options.stop = [&stops] { return stops; };
  const auto recording = open_rosbag2(dir / "a.db3", options);
  ASSERT_TRUE(recording->next());
  stops = true;
  EXPECT_THROW(
      {
        while (recording->next()) {
        }
      },
      ReadingStopped);
}

// Folders

TEST(Rosbag2Reader, FilesOfAFolderInTheirOrder) {
  const TempDir dir;
  make_log(dir / "run_10.db3", 20, 10);
  make_log(dir / "run_2.db3", 10, 10);
  make_log(dir / "run_1.db3", 0, 10);
  const Reading by_number = read(dir.path().string());
  EXPECT_EQ(numbers_of(by_number.messages), range(0, 30));
  EXPECT_THAT(by_number.damage, IsEmpty());
  EXPECT_EQ(by_number.recording->topics().size(), 2U) << "the same topics in all files";
  EXPECT_THAT(by_number.recording->notes(), ElementsAre(HasSubstr("no metadata.yaml")));
  EXPECT_THAT(rosbag2_files(dir.path().string()),
              ElementsAre(dir / "run_1.db3", dir / "run_2.db3", dir / "run_10.db3"));

  dir.write("metadata.yaml", metadata_for({"run_2.db3", "run_10.db3"}));
  EXPECT_THAT(rosbag2_files(dir.path().string()),
              ElementsAre(dir / "run_2.db3", dir / "run_10.db3"));
  EXPECT_THAT(read(dir.path().string()).recording->notes(),
              ElementsAre(HasSubstr("run_1.db3 is not")));
}

TEST(Rosbag2Reader, TopicsOfLaterFilesAreKnownAtOnce) {
  const TempDir dir;
  make_log(dir / "run_0.db3", 0, 4);
  {
    TestDatabase database(dir / "run_1.db3");
    make_tables(database);
    add_topic(database, "/late", "std_msgs/msg/String");
    add_topic(database, "/b", "sensor_msgs/msg/LaserScan");
    database.add_message(1, 5000, message_bytes(100));
    database.add_message(2, 6000, message_bytes(101));
  }
  const auto recording = open_rosbag2(dir.path().string(), {});
  ASSERT_EQ(recording->topics().size(), 3U);
  EXPECT_EQ(recording->topics()[2].name, "/late");
  int asked = 0;
  recording->want([&asked](const RecordedTopic& topic) {
    ++asked;
    return topic.name != "/a";
  });
  EXPECT_THAT(numbers_of(read_messages(*recording)), ElementsAre(1, 3, 100, 101));
  recording->rewind();
  EXPECT_EQ(read_messages(*recording).back().topic, "/b");
  EXPECT_EQ(asked, 3) << "once for each topic";
}

TEST(Rosbag2Reader, MovedPathsAndMissingFiles) {
  const TempDir dir;
  make_log(dir / "run_0.db3", 0, 10);
  make_log(dir / "run_2.db3", 20, 10);
  dir.write("metadata.yaml",
            metadata_for({"/nowhere/at/all/run_0.db3", "run/run_1.db3", "x/run_2.db3"}));
  Reading reading = read(dir.path().string());
  EXPECT_EQ(reading.messages.size(), 20U);
  EXPECT_THAT(reading.damage, ElementsAre(HasSubstr("'run/run_1.db3' is missing")));
  reading.recording->rewind();
  EXPECT_EQ(read_messages(*reading.recording).size(), 20U);
  EXPECT_EQ(reading.damage.size(), 1U) << "told twice";
}

TEST(Rosbag2Reader, LastFilesThatARecorderDidNotList) {
  const TempDir dir;
  make_log(dir / "run_0.db3", 0, 10);
  make_log(dir / "run_1.db3", 10, 10);
  dir.write("metadata.yaml", metadata_for({"run_0.db3"}));
  const Reading reading = read(dir.path().string());
  EXPECT_EQ(numbers_of(reading.messages), range(0, 20));
  EXPECT_THAT(reading.recording->notes(), ElementsAre(HasSubstr("run_1.db3 is read, too")));
}

TEST(Rosbag2Reader, DamagedOrWrongMetadata) {
  const TempDir dir;
  make_log(dir / "run_0.db3", 0, 10);
  dir.write("metadata.yaml", "rosbag2_bagfile_information: [\n");
  const Reading damaged = read(dir.path().string());
  EXPECT_EQ(damaged.messages.size(), 10U);
  EXPECT_THAT(damaged.damage, ElementsAre(HasSubstr("metadata.yaml")));
  dir.write("metadata.yaml", metadata_for({"other_0.db3"}));
  const Reading wrong = read(dir.path().string());
  EXPECT_EQ(wrong.messages.size(), 10U);
  EXPECT_THAT(wrong.recording->notes(), ElementsAre(HasSubstr("none of the files")));
}

TEST(Rosbag2Reader, CountsOfMetadata) {
  const TempDir dir;
  make_log(dir / "run_0.db3", 0, 10);
  dir.write("metadata.yaml",
            metadata_for({"run_0.db3"},
                         "  topics_with_message_count:\n    - topic_metadata:\n        name: /b\n"
                         "      message_count: 5\n"));
  const auto recording = open_rosbag2(dir.path().string(), {});
  EXPECT_EQ(recording->topics()[1].messages, 5);
  EXPECT_EQ(recording->topics()[0].messages, std::nullopt);
}

TEST(Rosbag2Reader, FoldersThatAreNone) {
  const TempDir dir;
  EXPECT_THAT(rosbag2_files(dir.path().string()), IsEmpty());
  EXPECT_THAT(refusal_of(dir.path().string()), HasSubstr("holds no recording"));
  dir.write("metadata.yaml", metadata_for({"gone_0.db3"}));
  EXPECT_THAT(rosbag2_files(dir.path().string()), IsEmpty());
  EXPECT_THAT(refusal_of(dir.path().string()), HasSubstr("none of the files"));
}

TEST(Rosbag2Reader, OneBrokenFileOfSeveral) {
  const TempDir dir;
  make_log(dir / "run_0.db3", 0, 10);
  dir.write("run_1.db3", "no database");
  dir.write("run_2.db3", "");
  make_log(dir / "run_3.db3", 30, 10);
  const Reading reading = read(dir.path().string());
  EXPECT_EQ(reading.messages.size(), 20U);
  EXPECT_THAT(reading.damage, ElementsAre(HasSubstr("run_1.db3: is no SQLite database"),
                                          HasSubstr("run_2.db3: is empty")));
}

TEST(Rosbag2Reader, NumbersInNames) {
  EXPECT_TRUE(is_before_by_number("a_2", "a_10"));
  EXPECT_FALSE(is_before_by_number("a_10", "a_2"));
  EXPECT_TRUE(is_before_by_number("a_02", "a_3"));
  EXPECT_TRUE(is_before_by_number("a", "a_0"));
  EXPECT_FALSE(is_before_by_number("a", "a"));
  EXPECT_TRUE(is_before_by_number("a_99999999999999999999998", "a_99999999999999999999999"));
}

// Packed

TEST(Rosbag2Reader, PackedFiles) {
  const TempDir dir;
  const auto before = temporary_folders();
  for (const int i : {0, 1}) {
    const std::string name = "run_" + std::to_string(i) + ".db3";
    make_log(dir / name, 100 * i, 100);
    dir.write(name + ".zstd", test::packed_by_zstd(dir.read(name)));
    fs::remove(dir / name);
  }
  dir.write("metadata.yaml",
            metadata_for({"run_0.db3", "run_1.db3.zstd"},
                         "  compression_mode: FILE\n  compression_format: zstd\n"));
  const Reading reading = read(dir.path().string());
  EXPECT_EQ(numbers_of(reading.messages), range(0, 200));
  EXPECT_THAT(reading.damage, IsEmpty());
  EXPECT_THAT(reading.recording->notes(),
              ElementsAre(HasSubstr("unpacked into a temporary"), HasSubstr("run_1.db3.zstd")));
  EXPECT_EQ(temporary_folders(), before) << "removed while it is still being read";
  EXPECT_EQ(reading.recording->progress().bytes_done, reading.recording->progress().bytes_total);
  reading.recording->rewind();
  EXPECT_EQ(read_messages(*reading.recording).size(), 200U);
  EXPECT_EQ(dir.names(),
            (std::vector<std::string>{"metadata.yaml", "run_0.db3.zstd", "run_1.db3.zstd"}));
  EXPECT_EQ(numbers_of(read(dir / "run_1.db3.zstd").messages), range(100, 100));
}

TEST(Rosbag2Reader, PackedFileThatEndsEarly) {
  const TempDir dir;
  make_log(dir / "a.db3", 0, 3000, 4, 300);
  const std::string packed = test::packed_by_zstd(dir.read("a.db3"));
  dir.write("b.db3.zstd", std::string_view(packed).substr(0, packed.size() * 2 / 3));
  const Reading reading = read(dir / "b.db3.zstd");
  EXPECT_GT(reading.messages.size(), 500U);
  ASSERT_FALSE(reading.damage.empty());
  EXPECT_THAT(reading.damage[0], HasSubstr("b.db3.zstd: can't be unpacked as a whole"));
}

TEST(Rosbag2Reader, PackedMessages) {
  const TempDir dir;
  {
    TestDatabase database(dir / "run_0.db3");
    make_tables(database);
    add_topic(database, "/a", "std_msgs/msg/String");
    for (int i = 0; i < 5; ++i) {
      std::string packed = test::packed_by_zstd(message_bytes(i, 100'000));
      if (i == 2) packed.resize(packed.size() / 2);
      if (i == 3) packed[10] = static_cast<char>(packed[10] ^ 0x55);
      database.add_message(1, i, packed);
    }
  }
  const Reading reading = read(dir / "run_0.db3");  // without metadata.yaml, too
  ASSERT_GE(reading.messages.size(), 3U);
  EXPECT_EQ(reading.messages[0].bytes, message_bytes(0, 100'000));
  EXPECT_EQ(reading.messages.back().bytes, message_bytes(4, 100'000));
  EXPECT_THAT(reading.damage, testing::Contains(HasSubstr("message 3 can't be unpacked")));

  dir.write(
      "metadata.yaml",
      metadata_for({"run_0.db3"}, "  compression_mode: MESSAGE\n  compression_format: lz9\n"));
  const auto recording = open_rosbag2(dir.path().string(), {});
  EXPECT_EQ(recording->topics()[0].unreadable, "packed with lz9");
}

TEST(Rosbag2Reader, PackedMessagesWithinMcap) {
  const TempDir dir;
  auto messages = test::some_messages(20);
  auto packed = messages;
  for (test::BuiltMessage& message : packed) message.bytes = test::packed_by_zstd(message.bytes);
  packed[7].bytes.resize(packed[7].bytes.size() / 2);
  messages.erase(messages.begin() + 7);
  dir.write("run_0.mcap", test::build_mcap(packed, {}).bytes);
  dir.write(
      "metadata.yaml",
      metadata_for({"run_0.mcap"}, "  compression_mode: MESSAGE\n  compression_format: zstd\n"));
  const Reading reading = read(dir.path().string());
  EXPECT_THAT(reading.damage, ElementsAre(HasSubstr("this message can't be unpacked")));
  ASSERT_EQ(reading.messages.size(), messages.size());
  for (std::size_t i = 0; i < messages.size(); ++i) {
    EXPECT_EQ(reading.messages[i].bytes, messages[i].bytes) << i;
  }
}

TEST(Rosbag2Reader, PackedTraps) {
  const TempDir dir;
  const std::string zeros(std::size_t{300} << 20, '\0');
  const std::string packed = test::packed_by_zstd(zeros);
  ASSERT_LT(packed.size(), 100'000U);
  dir.write("a.db3.zstd", packed);
  EXPECT_THAT(refusal_of(dir / "a.db3.zstd"), HasSubstr("when it is unpacked"));
  {
    TestDatabase database(dir / "b.db3");
    make_tables(database);
    add_topic(database, "/a", "std_msgs/msg/String");
    database.add_message(1, 1, packed);
    database.add_message(1, 2, message_bytes(2));
  }
  std::vector<std::string> damage;
  RecordingOptions options = telling(damage);
  options.memory.ceiling_bytes = 1 << 25;
  const auto recording = open_rosbag2(dir / "b.db3", options);
  EXPECT_THAT(numbers_of(read_messages(*recording)), ElementsAre(2));
  EXPECT_THAT(damage, ElementsAre(HasSubstr("larger than 34 MB")));
}

// Left by a recorder that was killed

/// A copy of a database with what lies beside it while it is written.
void copy_while_open(const TempDir& from, const std::string& name, const TempDir& to) {
  for (const char* end : {"", "-wal", "-shm", "-journal"}) {
    if (fs::exists(from / (name + end))) fs::copy_file(from / (name + end), to / (name + end));
  }
}

TEST(Rosbag2Reader, LogOfWritesIsIncluded) {
  const TempDir made;
  const TempDir dir;
  {
    TestDatabase database(made / "a.db3");
    database.run("PRAGMA journal_mode=WAL; PRAGMA wal_autocheckpoint=0;");
    make_tables(database);
    add_topic(database, "/a", "std_msgs/msg/String");
    add_topic(database, "/b", "std_msgs/msg/String");
    fill(database, 0, 100);
    database.run("PRAGMA wal_checkpoint(TRUNCATE)");
    fill(database, 100, 100);
    copy_while_open(made, "a.db3", dir);
  }
  const auto names = dir.names();
  const auto before = temporary_folders();
  ASSERT_THAT(names, testing::Contains("a.db3-wal"));
  const std::string log = dir.read("a.db3-wal");
  const std::string main = dir.read("a.db3");
  ::chmod(dir.path().c_str(), 0555);
  const Reading reading = read(dir / "a.db3");
  ::chmod(dir.path().c_str(), 0755);
  EXPECT_EQ(numbers_of(reading.messages), range(0, 200));
  EXPECT_THAT(reading.damage, IsEmpty());
  EXPECT_THAT(reading.recording->notes(), ElementsAre(HasSubstr("log of writes")));
  EXPECT_EQ(dir.names(), names) << "something was made or removed beside it";
  EXPECT_EQ(dir.read("a.db3-wal"), log);
  EXPECT_EQ(dir.read("a.db3"), main);
  EXPECT_EQ(temporary_folders(), before);

  fs::resize_file(dir / "a.db3-wal", log.size() / 2);
  EXPECT_GT(read(dir / "a.db3").messages.size(), 99U);
  fs::resize_file(dir / "a.db3-wal", 0);
  EXPECT_EQ(numbers_of(read(dir / "a.db3").messages), range(0, 100));
  fs::remove(dir / "a.db3-wal");
  fs::remove(dir / "a.db3-shm");
  EXPECT_EQ(numbers_of(read(dir / "a.db3").messages), range(0, 100));
  EXPECT_EQ(dir.names(), std::vector<std::string>{"a.db3"}) << "it is of the kind with a log";
}

TEST(Rosbag2Reader, JournalIsRolledBack) {
  const TempDir made;
  const TempDir dir;
  {
    TestDatabase database(made / "a.db3");
    database.run("PRAGMA journal_mode=DELETE; PRAGMA cache_size=2;");
    make_tables(database);
    add_topic(database, "/a", "std_msgs/msg/String");
    add_topic(database, "/b", "std_msgs/msg/String");
    fill(database, 0, 200, 500);
    database.run("BEGIN; UPDATE messages SET timestamp = 1, data = x'00';");
    copy_while_open(made, "a.db3", dir);
    database.run("ROLLBACK");
  }
  ASSERT_THAT(dir.names(), ElementsAre("a.db3", "a.db3-journal"));
  const Reading reading = read(dir / "a.db3");
  EXPECT_EQ(numbers_of(reading.messages), range(0, 200));
  EXPECT_THAT(reading.recording->notes(), ElementsAre(HasSubstr("journal")));
  EXPECT_THAT(dir.names(), ElementsAre("a.db3", "a.db3-journal"));
}

TEST(Rosbag2Reader, NoRoomForCopies) {
  const TempDir made;
  const TempDir dir;
  {
    TestDatabase database(made / "a.db3");
    database.run("PRAGMA journal_mode=WAL; PRAGMA wal_autocheckpoint=0;");
    make_tables(database);
    add_topic(database, "/a", "std_msgs/msg/String");
    add_topic(database, "/b", "std_msgs/msg/String");
    fill(database, 0, 10);
    database.run("PRAGMA wal_checkpoint(TRUNCATE)");
    fill(database, 10, 10);
    copy_while_open(made, "a.db3", dir);
  }
  const char* const before = std::getenv("TMPDIR");
  const std::string kept = before != nullptr ? before : "";
  ::setenv("TMPDIR", "/proc", 1);
  std::vector<std::string> damage;
  std::vector<std::int64_t> numbers;
  std::string refusal = "none";
  try {
    const auto recording = open_rosbag2(dir / "a.db3", telling(damage));
    numbers = numbers_of(read_messages(*recording));
  } catch (const DataError& error) {
    refusal = error.what();
  }
  if (before != nullptr) {
    ::setenv("TMPDIR", kept.c_str(), 1);
  } else {
    ::unsetenv("TMPDIR");
  }
  EXPECT_EQ(refusal, "none");
  EXPECT_EQ(numbers, range(0, 10));
  EXPECT_THAT(damage, ElementsAre(HasSubstr("is left out")));
}

// Damage

constexpr std::size_t kPage = 4096;

/// What is given of a damaged database is what was written, each message once.
void expect_true_messages(const Reading& reading, std::size_t size) {
  std::set<std::int64_t> seen;
  for (const auto& message : reading.messages) {
    const std::int64_t number = test::number_of(message.bytes);
    EXPECT_EQ(message.bytes, message_bytes(number, size));
    EXPECT_EQ(message.time_ns, 1000 * number);
    EXPECT_TRUE(seen.insert(number).second) << number << " came twice";
  }
}

/// \param by_time  with an index
void zero_pages_one_by_one(bool by_time, std::size_t size) {
  const TempDir dir;
  constexpr std::int64_t kCount = 2000;
  make_log(dir / "good.db3", 0, kCount, 4, size, by_time);
  const std::string good = dir.read("good.db3");
  int whole = 0;
  int most_lost = 0;
  std::size_t refused = 0;
  for (std::size_t at = 0; at < good.size(); at += kPage) {
    std::string bad = good;
    bad.replace(at, kPage, kPage, '\0');
    dir.write("bad.db3", bad);
    try {
      const Reading reading = read(dir / "bad.db3");
      expect_true_messages(reading, size);
      const int lost = static_cast<int>(kCount) - static_cast<int>(reading.messages.size());
      if (lost > 0) {
        EXPECT_FALSE(reading.damage.empty()) << lost << " lost at byte " << at;
      } else {
        ++whole;
      }
      // What hangs on the root of the table is lost with it.
      if (lost < kCount) most_lost = std::max(most_lost, lost);
    } catch (const DataError&) {
      ++refused;
    }
  }
  EXPECT_LE(refused, 4U) << "the first page and the roots of tables";
  // A page holds so many messages.
  EXPECT_LE(most_lost, static_cast<int>(kPage / size + 1)) << "more was lost than was damaged";
  if (by_time) {
    EXPECT_GT(whole, 5) << "damage of the index loses nothing";
  }
}

TEST(Rosbag2Reader, ZeroedPagesWithAnIndex) { zero_pages_one_by_one(true, 200); }
TEST(Rosbag2Reader, ZeroedPagesWithoutAnIndex) { zero_pages_one_by_one(false, 200); }

TEST(Rosbag2Reader, CutAnywhere) {
  for (const bool by_time : {true, false}) {
    const TempDir dir;
    constexpr std::int64_t kCount = 2000;
    constexpr std::size_t kSize = 300;
    make_log(dir / "good.db3", 0, kCount, 4, kSize, by_time);
    const std::string good = dir.read("good.db3");
    std::size_t before = 0;
    for (std::size_t percent = 10; percent < 100; percent += 6) {
      const std::size_t kept = good.size() * percent / 100;
      dir.write("cut.db3", std::string_view(good).substr(0, kept));
      const Reading reading = read(dir / "cut.db3");
      expect_true_messages(reading, kSize);
      ASSERT_FALSE(reading.damage.empty());
      EXPECT_THAT(reading.damage[0], HasSubstr("the file ends early"));
      // Nearly all that is in the pages that are there.
      EXPECT_GE(reading.messages.size() + 90, kCount * percent / 100) << percent << by_time;
      EXPECT_GE(reading.messages.size(), before);
      before = reading.messages.size();
    }
  }
}

TEST(Rosbag2Reader, ZeroedPartOfALargeMessage) {
  const TempDir dir;
  make_log(dir / "a.db3", 0, 50, 4, 40'000);
  std::string bytes = dir.read("a.db3");
  const std::size_t at = bytes.find(message_bytes(20, 60).substr(4, 30));
  ASSERT_NE(at, bytes.npos);
  // The page behind begins with where the next one is.
  const std::size_t next = (at / kPage + 3) * kPage;
  bytes.replace(next, kPage, kPage, '\0');
  dir.write("b.db3", bytes);
  const Reading reading = read(dir / "b.db3");
  expect_true_messages(reading, 40'000);
  EXPECT_EQ(reading.messages.size(), 49U);
  EXPECT_THAT(reading.damage, ElementsAre(HasSubstr("can't be read (database disk image")));
}

TEST(Rosbag2Reader, IndexThatLacksMessages) {
  const TempDir dir;
  make_log(dir / "a.db3", 0, 500);
  {
    // As after a crash: the index is of an earlier state of the table.
    TestDatabase database(dir / "a.db3");
    const std::int64_t root =
        database.number("SELECT rootpage FROM sqlite_master WHERE name='timestamp_idx'");
    database.run(
        "PRAGMA writable_schema=ON;"
        "DELETE FROM sqlite_master WHERE name='timestamp_idx';");
    ASSERT_GT(root, 0);
    TestDatabase other(dir / "a.db3");  // it knows of no index
    for (int i = 500; i < 510; ++i) other.add_message(1, 1000 * i, message_bytes(i));
    other.run(
        "PRAGMA writable_schema=ON; INSERT INTO sqlite_master VALUES('index','timestamp_idx',"
        "'messages'," +
        std::to_string(root) + ",'CREATE INDEX timestamp_idx ON messages (timestamp ASC)');");
  }
  const Reading reading = read(dir / "a.db3");
  EXPECT_EQ(numbers_of(reading.messages), range(0, 510));
  EXPECT_THAT(reading.damage, ElementsAre(HasSubstr("lacks 10 messages")));
}

TEST(Rosbag2Reader, GapsInTheNumbersAreNoDamage) {
  const TempDir dir;
  make_log(dir / "a.db3", 0, 500);
  {
    TestDatabase database(dir / "a.db3");
    database.run("DELETE FROM messages WHERE id % 7 = 0");
  }
  const Reading reading = read(dir / "a.db3");
  EXPECT_EQ(reading.messages.size(), 429U);
  EXPECT_THAT(reading.damage, IsEmpty());
}

TEST(Rosbag2Reader, MessagesOfUnknownTopics) {
  const TempDir dir;
  make_log(dir / "a.db3", 0, 10);
  {
    TestDatabase database(dir / "a.db3");
    database.run("DELETE FROM topics WHERE id = 2");
  }
  const Reading reading = read(dir / "a.db3");
  EXPECT_THAT(numbers_of(reading.messages), ElementsAre(0, 2, 4, 6, 8));
  EXPECT_THAT(reading.damage, ElementsAre(HasSubstr("messages of topic 2 are left out")));
}

TEST(Rosbag2Reader, DamageIsToldOnce) {
  const TempDir dir;
  make_log(dir / "a.db3", 0, 2000, 4, 200);
  std::string bytes = dir.read("a.db3");
  bytes.replace(bytes.size() / 2 / kPage * kPage, kPage, kPage, '\0');
  dir.write("b.db3", bytes);
  Reading reading = read(dir / "b.db3");
  const std::size_t told = reading.damage.size();
  ASSERT_GT(told, 0U);
  reading.recording->rewind();
  EXPECT_EQ(read_messages(*reading.recording), reading.messages);
  EXPECT_EQ(reading.damage.size(), told);
}

// By place

/// That each message is found again by its place, by another recording of the same.
std::size_t expect_by_place(const std::string& path, const std::string& what = "") {
  const auto placed = test::placed_messages_of(*open_rosbag2(path, {}));
  return test::expect_by_place(placed, *open_rosbag2(path, {}), path + " " + what);
}

TEST(Rosbag2Reader, MessagesByTheirPlaces) {
  const TempDir dir;
  for (const bool with_index : {true, false}) {
    make_log(dir / "a.db3", 0, 200, 4, 300, with_index);
    EXPECT_EQ(expect_by_place(dir / "a.db3"), 200U);
    fs::remove(dir / "a.db3");
  }
  {
    TestDatabase database(dir / "packed.db3");
    make_tables(database);
    add_topic(database, "/a", "std_msgs/msg/String");
    for (int i = 0; i < 20; ++i) {
      database.add_message(1, i, test::packed_by_zstd(message_bytes(i, 50'000)));
    }
  }
  EXPECT_EQ(expect_by_place(dir / "packed.db3"), 20U);
  dir.write("b.db3.zstd", test::packed_by_zstd(dir.read("packed.db3")));
  EXPECT_EQ(expect_by_place(dir / "b.db3.zstd"), 20U);
}

TEST(Rosbag2Reader, MessagesOfAFolderByTheirPlaces) {
  const TempDir dir;
  make_log(dir / "run_0.db3", 0, 20);
  make_log(dir / "other.db3", 20, 20);
  dir.write("run_1.db3.zstd", test::packed_by_zstd(dir.read("other.db3")));
  auto messages = test::some_messages(20);
  dir.write("run_2.mcap.zstd",
            test::packed_by_zstd(test::build_mcap(messages, {.packing = Packing::kLz4}).bytes));
  for (auto& message : messages) message.bytes = test::packed_by_zstd(message.bytes);
  dir.write("run_3.mcap", test::build_mcap(messages, {}).bytes);
  dir.write("run_4.db3", "no database");
  const std::string mode = "  compression_mode: MESSAGE\n  compression_format: zstd\n";
  dir.write("metadata.yaml", metadata_for({"run_0.db3", "run_1.db3.zstd", "run_2.mcap.zstd",
                                           "run_3.mcap", "run_4.db3"},
                                          mode));
  EXPECT_EQ(expect_by_place(dir.path().string()), 80U);

  // In the middle of the reading, too.
  const std::string path = dir.path().string();
  const auto placed = test::placed_messages_of(*open_rosbag2(path, {}));
  EXPECT_EQ(placed.front().place.file, 0U);
  EXPECT_EQ(placed.back().place.file, 3U);
  const auto recording = open_rosbag2(path, {});
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const auto message = recording->next();
    ASSERT_TRUE(message);
    EXPECT_TRUE(std::ranges::equal(message->bytes, placed[i].bytes)) << i;
    EXPECT_EQ(message->place, placed[i].place);
    const auto& other = placed[(7 * i + 3) % placed.size()];
    EXPECT_TRUE(std::ranges::equal(recording->bytes_at(other.place), other.bytes)) << i;
  }
  EXPECT_FALSE(recording->next());
}

TEST(Rosbag2Reader, DamagedMessagesByTheirPlaces) {
  for (const bool by_time : {true, false}) {
    const TempDir dir;
    make_log(dir / "good.db3", 0, 600, 4, 300, by_time);
    const std::string good = dir.read("good.db3");
    for (std::size_t at = 0; at < good.size(); at += 3 * kPage) {
      std::string bad = good;
      bad.replace(at, kPage, kPage, '\0');
      dir.write("bad.db3", bad);
      dir.write("cut.db3", std::string_view(good).substr(0, good.size() - at));
      for (const char* name : {"bad.db3", "cut.db3"}) {
        if (refusal_of(dir / name) == "none") expect_by_place(dir / name, std::to_string(at));
      }
    }
    dir.write("a.db3.zstd", std::string_view(test::packed_by_zstd(good)).substr(0, 20'000));
    EXPECT_GT(expect_by_place(dir / "a.db3.zstd"), 10U);
  }
}

TEST(Rosbag2Reader, PlacesThatHoldAnotherMessage) {
  const TempDir dir;
  make_log(dir / "run_0.db3", 0, 20);
  dir.write("run_1.mcap.zstd",
            test::packed_by_zstd(test::build_mcap(test::some_messages(20), {}).bytes));
  const auto placed = test::placed_messages_of(*open_rosbag2(dir.path().string(), {}));
  const auto refusal = [&](MessagePlace place, const auto& change) -> std::string {
    change(place);
    try {
      (void)open_rosbag2(dir.path().string(), {})->bytes_at(place);
    } catch (const DataError& error) {
      return error.what();
    }
    return "none";
  };
  const MessagePlace row = placed[4].place;
  EXPECT_EQ(refusal(row, [](MessagePlace&) {}), "none");
  const std::string gone = "the message that was here is gone: the file was changed meanwhile";
  const std::string in_database = dir / "run_0.db3" + " (message 5): " + gone;
  EXPECT_EQ(refusal(row, [](MessagePlace& place) { ++place.recorded.nanoseconds; }), in_database);
  EXPECT_EQ(refusal(row, [](MessagePlace& place) { ++place.size; }), in_database);
  EXPECT_THAT(refusal(row, [](MessagePlace& place) { place.at = 21; }), HasSubstr(gone));
  EXPECT_THAT(refusal(row, [](MessagePlace& place) { place.file = 2; }), HasSubstr(gone));
  EXPECT_EQ(
      refusal(placed.back().place, [](MessagePlace& place) { ++place.size; }),
      dir / "run_1.mcap.zstd" + " (byte " + std::to_string(placed.back().place.at) + "): " + gone);
}

// Not what it seems

TEST(Rosbag2Reader, OtherFilesAreRefused) {
  const TempDir dir;
  EXPECT_THAT(refusal_of(dir / "none.db3"), HasSubstr("cannot open"));
  dir.write("a.db3", "text");
  EXPECT_THAT(refusal_of(dir / "a.db3"), HasSubstr("is no SQLite database"));
  {
    TestDatabase database(dir / "b.db3");
    database.run("CREATE TABLE places(id INTEGER PRIMARY KEY, url TEXT)");
  }
  EXPECT_THAT(refusal_of(dir / "b.db3"), HasSubstr("none of rosbag2"));
  dir.write("c.db3", std::string("SQLite format 3\0", 16) + std::string(5000, '\xFF'));
  EXPECT_NE(refusal_of(dir / "c.db3"), "none");
}

TEST(Rosbag2Reader, ViewsAndGeneratedColumnsAreNoTables) {
  const TempDir dir;
  {
    TestDatabase database(dir / "a.db3");
    make_tables(database);
    database.run(
        "ALTER TABLE messages RENAME TO other;"
        "CREATE VIEW messages AS SELECT * FROM other, topics;");
  }
  EXPECT_THAT(refusal_of(dir / "a.db3"), HasSubstr("none of rosbag2"));
  {
    TestDatabase database(dir / "b.db3");
    make_tables(database);
    database.run(
        "DROP TABLE messages; CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, "
        "timestamp, data BLOB GENERATED ALWAYS AS (zeroblob(900000000)));");
  }
  EXPECT_THAT(refusal_of(dir / "b.db3"), HasSubstr("none of rosbag2"));
}

TEST(Rosbag2Reader, HugeMessagesAreLeftOut) {
  const TempDir dir;
  make_log(dir / "a.db3", 0, 3, 4, 40);
  {
    TestDatabase database(dir / "a.db3");
    database.add_message(1, 5000, message_bytes(5, 20'000'000));
    database.add_message(1, 6000, message_bytes(6));
  }
  std::vector<std::string> damage;
  RecordingOptions options = telling(damage);
  options.memory.ceiling_bytes = std::uint64_t{1} << 24;
  const auto recording = open_rosbag2(dir / "a.db3", options);
  EXPECT_THAT(numbers_of(read_messages(*recording)), ElementsAre(0, 1, 2, 6));
  EXPECT_THAT(damage, ElementsAre(HasSubstr("message 4 can't be read (string or blob too big)")));
}

TEST(Rosbag2Reader, MemoryReadsLikeAFile) {
  const TempDir dir;
  make_log(dir / "a.db3", 0, 100);
  const std::string bytes = dir.read("a.db3");
  EXPECT_TRUE(is_sqlite(bytes));
  EXPECT_FALSE(is_sqlite("SQLite format 2"));
  const auto recording = read_sqlite_log(bytes, {});
  EXPECT_EQ(numbers_of(read_messages(*recording)), range(0, 100));
}

// metadata.yaml

TEST(Rosbag2Metadata, OldVersions) {
  const Rosbag2Metadata metadata = parse_rosbag2_metadata(
      "rosbag2_bagfile_information:\n  version: 3\n  storage_identifier: sqlite3\n"
      "  relative_file_paths:\n    - a.db3\n  compression_format: ZSTD\n"
      "  compression_mode: FILE\n");
  EXPECT_EQ(metadata.version, 3);
  EXPECT_THAT(metadata.files, ElementsAre("a.db3"));
  EXPECT_EQ(metadata.compression_mode, "file");
  EXPECT_EQ(metadata.compression_format, "zstd");
}

TEST(Rosbag2Metadata, WhatIsWrittenIsRead) {
  Rosbag2Contents contents;
  contents.storage = "sqlite3";
  contents.file = "my log\n_0.db3";
  contents.topics = {{"/a", "std_msgs/msg/String", "RIHS01_0", true, 3},
                     {"odd: \"name\" #1\t", "x/msg/Y", "", false, 4}};
  contents.messages = 7;
  const Rosbag2Metadata metadata = parse_rosbag2_metadata(format_rosbag2_metadata(contents));
  EXPECT_EQ(metadata.version, 9);
  EXPECT_THAT(metadata.files, ElementsAre(contents.file));
  EXPECT_EQ(metadata.messages.at("/a"), 3);
  EXPECT_EQ(metadata.messages.at(contents.topics[1].name), 4);
}

TEST(Rosbag2Metadata, WhatIsNoneIsRefused) {
  for (const std::string& text :
       {std::string("a: [1"), std::string("image: map.pgm"), std::string(), std::string("- 1"),
        std::string(1000, '['), std::string((std::size_t{1} << 22) + 1, ' ')}) {
    EXPECT_THROW((void)parse_rosbag2_metadata(text), DataError) << text.substr(0, 20);
  }
}

}  // namespace
}  // namespace loopstone
