#include "formats/sqlite_schema.hpp"

#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <map>
#include <stdexcept>

#include "loopstone/formats/log_reader.hpp"

namespace loopstone {
namespace {

/// Topics and definitions of one database; there are tens in a real one.
constexpr std::size_t kMostTopics = 65'536;
constexpr std::size_t kMostDefinitionBytes = std::size_t{1} << 26;

struct Definition {
  std::string hash{};
  MessageDefinition definition{};
};
using Definitions = std::map<std::string, std::vector<Definition>, std::less<>>;

bool has(const std::vector<std::string>& columns, std::string_view name) {
  return std::find(columns.begin(), columns.end(), name) != columns.end();
}

bool has_all(const std::vector<std::string>& columns,
             std::initializer_list<std::string_view> names) {
  return std::all_of(names.begin(), names.end(), [&](auto name) { return has(columns, name); });
}

/// The name of a column, or an empty text where an older version has none.
std::string or_nothing(const std::vector<std::string>& columns, const char* name) {
  return has(columns, name) ? sqlite_name(name) : "''";
}

bool is_plain_table(SqliteDatabase& database, const std::string& table) {
  SqliteStatement query(database,
                        "SELECT type, substr(sql, 1, 13) FROM sqlite_master WHERE name=?1");
  query.bind_text(1, table);
  if (!query.step()) return false;
  std::string words(query.text(1));
  std::transform(words.begin(), words.end(), words.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return query.text(0) == "table" && words == "CREATE TABLE ";
}

DefinitionLanguage language_of(std::string_view encoding) {
  if (encoding == "ros2msg") return DefinitionLanguage::kRos2Msg;
  if (encoding == "ros2idl") return DefinitionLanguage::kRos2Idl;
  if (encoding == "ros1msg") return DefinitionLanguage::kRos1Msg;
  return DefinitionLanguage::kNone;
}

Definitions read_definitions(SqliteDatabase& database) {
  Definitions definitions;
  const auto columns = sqlite_columns(database, "message_definitions");
  if (!has_all(columns, {"topic_type", "encoding", "encoded_message_definition"})) {
    return definitions;
  }
  SqliteStatement query(database, "SELECT topic_type, encoding, encoded_message_definition, " +
                                      or_nothing(columns, "type_description_hash") +
                                      " FROM message_definitions ORDER BY _rowid_");
  std::size_t bytes = 0;
  while (query.step()) {
    Definition definition;
    definition.definition.language = language_of(query.text(1));
    definition.hash = query.text(3);
    if (definition.definition.language == DefinitionLanguage::kNone) continue;
    definition.definition.text = query.text(2);
    bytes += definition.definition.text.size();
    if (bytes > kMostDefinitionBytes) {
      throw std::runtime_error("its definitions of messages are unusually long");
    }
    definitions[canonical_type(query.text(0))].push_back(std::move(definition));
  }
  return definitions;
}

/// That with the topic's hash, or the first of its type.
void add_definition(const Definitions& definitions, RecordedTopic& topic) {
  const auto found = definitions.find(topic.type);
  if (found == definitions.end()) return;
  const Definition* best = &found->second.front();
  for (const Definition& definition : found->second) {
    if (!topic.hash.empty() && definition.hash == topic.hash) {
      best = &definition;
      break;
    }
  }
  topic.definition = best->definition;
  if (topic.hash.empty()) topic.hash = best->hash;
}

}  // namespace

std::vector<std::string> sqlite_columns(SqliteDatabase& database, const std::string& table) {
  std::vector<std::string> columns;
  if (!is_plain_table(database, table)) return columns;
  SqliteStatement query(database, "PRAGMA table_info(" + sqlite_name(table) + ")");
  while (query.step()) columns.emplace_back(query.text(1));
  return columns;
}

std::vector<SqliteTopic> read_sqlite_topics(SqliteDatabase& database,
                                            const std::function<void(const std::string&)>& told) {
  const auto messages = sqlite_columns(database, "messages");
  const auto columns = sqlite_columns(database, "topics");
  if (!has_all(messages, {"topic_id", "timestamp", "data"}) || has(messages, "_rowid_") ||
      !has_all(columns, {"id", "name", "type"})) {
    throw std::runtime_error(
        "is a database, but none of rosbag2: it lacks the tables 'messages' "
        "and 'topics' or their columns");
  }
  Definitions definitions;
  try {
    definitions = read_definitions(database);
  } catch (const std::runtime_error& error) {
    if (dynamic_cast<const ReadingStopped*>(&error) != nullptr) throw;
    told("the definitions of its messages can't be read (" + std::string(error.what()) + ")");
  }
  std::vector<SqliteTopic> topics;
  try {
    SqliteStatement query(database, "SELECT id, name, type, " +
                                        or_nothing(columns, "serialization_format") + ", " +
                                        or_nothing(columns, "type_description_hash") +
                                        " FROM topics ORDER BY _rowid_");
    while (query.step() && topics.size() < kMostTopics) {
      SqliteTopic& topic = topics.emplace_back();
      topic.id = query.integer(0);
      topic.topic.name = query.text(1);
      topic.topic.type = canonical_type(query.text(2));
      topic.topic.hash = query.text(4);
      const std::string_view format = query.text(3);
      if (format == "ros1") topic.topic.format = WireFormat::kRos1;
      if (!format.empty() && format != "cdr" && format != "ros1") {
        topic.topic.unreadable = "encoded as " + std::string(format.substr(0, 40));
      }
      add_definition(definitions, topic.topic);
    }
  } catch (const SqliteError& error) {
    if (topics.empty()) throw;
    told("some of its topics can't be read (" + std::string(error.what()) + ")");
  }
  return topics;
}

std::optional<std::string> find_time_index(SqliteDatabase& database) {
  std::vector<std::string> names;
  {
    SqliteStatement list(database, "PRAGMA index_list(messages)");
    while (list.step()) {
      if (list.integer(4) == 0) names.emplace_back(list.text(1));  // it covers all rows
    }
  }
  for (const std::string& name : names) {
    int keys = 0;
    bool is_by_time = false;
    SqliteStatement columns(database, "PRAGMA index_xinfo(" + sqlite_name(name) + ")");
    while (columns.step()) {
      if (columns.integer(5) == 0) continue;
      ++keys;
      is_by_time = columns.text(2) == "timestamp" && columns.integer(3) == 0;
    }
    if (keys == 1 && is_by_time) return name;
  }
  return std::nullopt;
}

}  // namespace loopstone
