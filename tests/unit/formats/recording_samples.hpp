#pragma once

#include <sqlite3.h>
#include <zstd.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "formats/recording.hpp"
#include "formats/recording_writer.hpp"

// Recordings for tests, made without the library, and what is read of them.

namespace loopstone::test {

/// A database of SQLite that runs what it is told.
class TestDatabase {
 public:
  explicit TestDatabase(const std::string& path) {
    if (sqlite3_open(path.c_str(), &handle_) != SQLITE_OK) throw std::runtime_error(path);
    run("PRAGMA synchronous=OFF");
  }
  TestDatabase(const TestDatabase&) = delete;
  TestDatabase& operator=(const TestDatabase&) = delete;
  ~TestDatabase() { sqlite3_close_v2(handle_); }

  void run(const std::string& sql) {
    char* error = nullptr;
    if (sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, &error) != SQLITE_OK) {
      throw std::runtime_error(sql + ": " + error);
    }
  }
  void add_message(std::int64_t topic, std::int64_t time_ns, std::string_view bytes) {
    sqlite3_stmt* statement = nullptr;
    sqlite3_prepare_v2(handle_, "INSERT INTO messages (topic_id, timestamp, data) VALUES (?,?,?)",
                       -1, &statement, nullptr);
    sqlite3_bind_int64(statement, 1, topic);
    sqlite3_bind_int64(statement, 2, time_ns);
    sqlite3_bind_blob64(statement, 3, bytes.data(), bytes.size(), SQLITE_TRANSIENT);
    const int code = sqlite3_step(statement);
    sqlite3_finalize(statement);
    if (code != SQLITE_DONE) throw std::runtime_error(sqlite3_errmsg(handle_));
  }
  [[nodiscard]] std::int64_t number(const std::string& sql) {
    sqlite3_stmt* statement = nullptr;
    sqlite3_prepare_v2(handle_, sql.c_str(), -1, &statement, nullptr);
    const bool has_row = sqlite3_step(statement) == SQLITE_ROW;
    const std::int64_t value = has_row ? sqlite3_column_int64(statement, 0) : -1;
    sqlite3_finalize(statement);
    return value;
  }

 private:
  sqlite3* handle_ = nullptr;
};

/// Tables as rosbag2 has made them, from version 1 to 4 of its schema.
inline void make_tables(TestDatabase& database, int version = 4, bool with_index = true) {
  std::string topics =
      "CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,"
      "type TEXT NOT NULL,serialization_format TEXT NOT NULL";
  if (version >= 2) topics += ",offered_qos_profiles TEXT NOT NULL";
  if (version >= 4) topics += ",type_description_hash TEXT NOT NULL";
  database.run(topics + ");");
  database.run(
      "CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,"
      "timestamp INTEGER NOT NULL, data BLOB NOT NULL);");
  if (with_index) database.run("CREATE INDEX timestamp_idx ON messages (timestamp ASC);");
  if (version >= 3) {
    database.run(
        "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY,ros_distro TEXT NOT NULL);"
        "CREATE TABLE metadata(id INTEGER PRIMARY KEY,metadata_version INTEGER NOT NULL,"
        "metadata TEXT NOT NULL);");
  }
  if (version >= 4) {
    database.run(
        "CREATE TABLE message_definitions(id INTEGER PRIMARY KEY,topic_type TEXT NOT NULL,"
        "encoding TEXT NOT NULL,encoded_message_definition TEXT NOT NULL,"
        "type_description_hash TEXT NOT NULL);");
  }
}

inline void add_topic(TestDatabase& database, const std::string& name, const std::string& type,
                      int version = 4, const std::string& format = "cdr") {
  std::string sql =
      "INSERT INTO topics VALUES (NULL,'" + name + "','" + type + "','" + format + "'";
  if (version >= 2) sql += ",''";
  if (version >= 4) sql += ",'RIHS01_of_" + name + "'";
  database.run(sql + ");");
}

/// Bytes that tell which message they are of.
inline std::string message_bytes(std::int64_t number, std::size_t size = 40) {
  std::string bytes("\0\1\0\0", 4);
  bytes += std::to_string(number) + ";";
  while (bytes.size() < size) bytes += static_cast<char>('a' + (bytes.size() + number) % 26);
  return bytes;
}

inline std::int64_t number_of(std::string_view bytes) {
  return std::stoll(std::string(bytes.substr(4, bytes.find(';') - 4)));
}

inline std::string packed_by_zstd(std::string_view bytes) {
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), 3));
  return packed;
}

struct ReadMessage {
  std::string topic{};
  std::int64_t time_ns = 0;
  std::string bytes{};
  bool operator==(const ReadMessage&) const = default;
};

inline std::vector<ReadMessage> read_messages(Recording& recording) {
  std::vector<ReadMessage> messages;
  while (const auto message = recording.next()) {
    messages.push_back({recording.topics().at(message->topic).name, message->recorded.nanoseconds,
                        std::string(message->bytes.begin(), message->bytes.end())});
  }
  return messages;
}

/// The numbers that message_bytes() was given.
inline std::vector<std::int64_t> numbers_of(const std::vector<ReadMessage>& messages) {
  std::vector<std::int64_t> numbers;
  for (const ReadMessage& message : messages) numbers.push_back(number_of(message.bytes));
  return numbers;
}

inline WrittenTopic string_topic(const std::string& name, bool latched = false) {
  return {.name = name,
          .type = "std_msgs/String",
          .ros1_definition = "string data",
          .ros2_definition = "string data",
          .md5 = "992ce8a1687cec8c8bd883ec73ca41d1",
          .rihs01 = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
          .latched = latched};
}

}  // namespace loopstone::test
