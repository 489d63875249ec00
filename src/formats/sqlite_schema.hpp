#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "formats/recording.hpp"
#include "formats/sqlite_database.hpp"

// What the tables of a rosbag2 database look like, whatever version made them.

namespace loopstone {

struct SqliteTopic {
  std::int64_t id = 0;
  RecordedTopic topic{};
};

/// Of a table, as it stands in the schema; empty when there is none of that name or it is no plain
/// table.
[[nodiscard]] std::vector<std::string> sqlite_columns(SqliteDatabase& database,
                                                      const std::string& table);

/// \param told  called with what is wrong with a part that was passed over
/// Throws SqliteError when the tables can't be read, std::runtime_error when they are not those of
/// a recording.
[[nodiscard]] std::vector<SqliteTopic> read_sqlite_topics(
    SqliteDatabase& database, const std::function<void(const std::string&)>& told);

/// An index that gives the messages by their times, or nothing.
[[nodiscard]] std::optional<std::string> find_time_index(SqliteDatabase& database);

}  // namespace loopstone
