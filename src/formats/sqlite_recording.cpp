#include "formats/sqlite_recording.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "formats/sqlite_database.hpp"
#include "formats/sqlite_schema.hpp"
#include "formats/sqlite_walk.hpp"
#include "formats/temporary_folder.hpp"
#include "formats/zstd_unpack.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMagic{"SQLite format 3\0", 16};
constexpr int kMessagesBetweenQuestions = 64;

std::uint64_t file_bytes(const std::string& path) {
  std::error_code error;
  const auto bytes = fs::file_size(path, error);
  return error ? 0 : bytes;
}

std::string first_bytes_of(const std::string& path, std::size_t count) {
  std::string bytes(count, '\0');
  std::size_t size = 0;
  if (std::FILE* file = std::fopen(path.c_str(), "rb")) {
    size = std::fread(bytes.data(), 1, count, file);
    std::fclose(file);
  }
  bytes.resize(size);
  return bytes;
}

std::uint64_t big_endian(std::string_view bytes, std::size_t at, std::size_t size) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) {
    value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  }
  return value;
}

/// Bytes that the head of a database says there are; 0 when it doesn't.
std::uint64_t stated_bytes(std::string_view head) {
  constexpr std::size_t kHead = 100;
  if (head.size() < kHead || big_endian(head, 24, 4) != big_endian(head, 92, 4)) return 0;
  const std::uint64_t page = big_endian(head, 16, 2);
  return big_endian(head, 28, 4) * (page == 1 ? 65'536 : page);
}

/// A log of writes, or a journal that was in use, which a recorder left when it was killed.
std::optional<std::string> left_beside(const std::string& path) {
  constexpr std::uint64_t kLogHead = 32;
  constexpr std::string_view kJournalMagic = "\xD9\xD5\x05\xF9\x20\xA1\x63\xD7";
  if (file_bytes(path + "-wal") > kLogHead) return "-wal";
  if (first_bytes_of(path + "-journal", kJournalMagic.size()) == kJournalMagic) return "-journal";
  return std::nullopt;
}

class SqliteRecording final : public Recording {
 public:
  SqliteRecording(SqliteLog log, const RecordingOptions& options)
      : log_(std::move(log)), options_(options) {}

  void open_file() {
    const std::string head = first_bytes_of(log_.path, 100);
    if (head.empty()) throw DataError({log_.name}, "is empty");
    if (!is_sqlite(head)) {
      throw DataError({log_.name}, "is no SQLite database: it does not begin like one");
    }
    file_bytes_ = loopstone::file_bytes(log_.path);
    if (stated_bytes(head) > file_bytes_ && !left_beside(log_.path)) {
      tell(fmt::format("the file ends early: {} of {} are there", bytes_text(file_bytes_),
                       bytes_text(stated_bytes(head))));
    }
    std::string path = log_.path;
    SqliteOptions options = database_options();
    TemporaryFolder* copies = nullptr;
    std::unique_ptr<TemporaryFolder> folder;
    if (const auto left = left_beside(log_.path)) {
      folder = copy_with(*left, path);
      if (folder) options.access = SqliteAccess::kRecover;
      copies = folder.get();
    }
    connect([&](bool is_tolerant) {
      options.is_tolerant = is_tolerant;
      return std::make_unique<SqliteDatabase>(path, options);
    });
    if (copies != nullptr) copies->remove();  // what is open stays readable, whatever happens
  }

  void open_bytes(std::string_view bytes) {
    file_bytes_ = bytes.size();
    if (!is_sqlite(bytes)) {
      throw DataError({log_.name}, "is no SQLite database: it does not begin like one");
    }
    SqliteOptions options = database_options();
    connect([&](bool is_tolerant) {
      options.is_tolerant = is_tolerant;
      return std::make_unique<SqliteDatabase>(bytes, options);
    });
  }

  const std::vector<RecordedTopic>& topics() const override { return topics_; }
  bool is_indexed() const override { return true; }

  void want(std::function<bool(const RecordedTopic&)> wanted) override {
    wants_.clear();
    for (const RecordedTopic& topic : topics_) wants_.push_back(!wanted || wanted(topic));
    prepare_row();
  }

  std::optional<RecordedMessage> next() override {
    while (true) {
      if (++asked_ % kMessagesBetweenQuestions == 0 && options_.stop && options_.stop()) {
        throw ReadingStopped();
      }
      const auto row = walk_->next();
      if (!row) {
        is_at_end_ = true;
        return std::nullopt;
      }
      ++rows_;
      if (auto message = read(*row)) return message;
    }
  }

  std::span<const char> bytes_at(const MessagePlace& place) override {
    where_ = name_of(place.at);
    std::span<const char> bytes;
    try {
      bytes = stored_at(place);
    } catch (const SqliteError& error) {
      throw DataError({where_}, fmt::format("can't be read ({})", error.what()));
    }
    if (const auto fault = unpack(bytes)) throw DataError({where_}, *fault);
    return bytes;
  }

  void rewind() override {
    row_->reset();
    placed_row_.reset();
    walk_->rewind();
    // Damage is found when a page is read: what stayed in memory would pass for whole.
    sqlite3_db_release_memory(database_->handle());
    rows_ = 0;
    is_at_end_ = false;
  }

  ReadProgress progress() const override {
    ReadProgress progress{0, log_.stored_bytes};
    if (is_at_end_) {
      progress.bytes_done = log_.stored_bytes;
    } else if (last_row_ > 0) {
      const double share = static_cast<double>(rows_) / static_cast<double>(last_row_);
      progress.bytes_done =
          static_cast<std::int64_t>(static_cast<double>(log_.stored_bytes) * std::min(1.0, share));
    }
    return progress;
  }

  std::vector<std::string> notes() const override { return notes_; }

 private:
  [[nodiscard]] SqliteOptions database_options() const {
    SqliteOptions options;
    options.most_value_bytes = most_message_bytes();
    options.stop = options_.stop;
    return options;
  }
  [[nodiscard]] std::uint64_t most_message_bytes() const {
    return options_.memory.allowed_bytes(file_bytes_, Growth::kNumbers);
  }
  void tell(const std::string& reason) const {
    if (options_.on_damage) options_.on_damage({{log_.name}, reason});
  }

  /// Nothing when there is no room for copies.
  [[nodiscard]] std::unique_ptr<TemporaryFolder> copy_with(const std::string& ending,
                                                           std::string& path) {
    const std::string what = ending == "-wal" ? "log of writes" : "journal";
    const auto tell_left_out = [&](const std::string& why) {
      tell("its " + what + " (" + ending + ") is left out, because it can't be copied: " + why);
    };
    try {
      auto folder = std::make_unique<TemporaryFolder>();
      const std::string copy = *folder / "recording.db3";
      for (const std::string& end : {std::string(), ending}) {
        if (options_.stop && options_.stop()) throw ReadingStopped();
        fs::copy_file(path + end, copy + end);
        fs::permissions(copy + end, fs::perms::owner_read | fs::perms::owner_write);
      }
      path = copy;
      notes_.push_back("the recorder of " + log_.name + " did not close it: its " + what + " (" +
                       ending + ") was read, too, from a copy");
      return folder;
    } catch (const fs::filesystem_error& error) {
      tell_left_out(error.code().message());
    } catch (const DataError& error) {
      tell_left_out(error.what());
    }
    return nullptr;
  }

  /// \param make  makes a connection, one that is tolerant when asked to
  void connect(const std::function<std::unique_ptr<SqliteDatabase>(bool)>& make) {
    for (const bool is_tolerant : {false, true}) {
      try {
        database_ = make(is_tolerant);
        read_schema();
        return;
      } catch (const SqliteError& error) {
        walk_.reset();
        row_.reset();
        placed_row_.reset();
        if (is_tolerant || error.code() != SQLITE_CORRUPT) {
          throw DataError({log_.name},
                          "nothing in this database can be read: " + std::string(error.what()));
        }
      } catch (const ReadingStopped&) {
        throw;
      } catch (const DataError&) {
        throw;
      } catch (const std::bad_alloc&) {
        throw_too_large();
      } catch (const std::runtime_error& error) {
        throw DataError({log_.name}, error.what());
      }
    }
  }

  [[noreturn]] void throw_too_large() const {
    throw DataError({log_.name},
                    "needs more memory than there is: damage makes its tables look so large");
  }

  void read_schema() {
    topics_.clear();
    by_id_.clear();
    const auto tell_reason = [this](const std::string& reason) { tell(reason); };
    for (SqliteTopic& topic : read_sqlite_topics(*database_, tell_reason)) {
      if (!log_.packing.empty() && log_.packing != "zstd" && topic.topic.unreadable.empty()) {
        topic.topic.unreadable = "packed with " + log_.packing.substr(0, 40);
      }
      by_id_.emplace(topic.id, topics_.size());
      topics_.push_back(std::move(topic.topic));
    }
    wants_.assign(topics_.size(), true);
    try {
      SqliteStatement last(*database_, "SELECT max(_rowid_) FROM messages");
      last_row_ = last.step() ? last.integer(0) : 0;
    } catch (const SqliteError&) {
      last_row_ = 0;  // progress stays unknown
    }
    std::optional<std::string> index;
    try {
      index = find_time_index(*database_);
    } catch (const SqliteError& error) {
      tell("the index of its times can't be found (" + std::string(error.what()) + ")");
    }
    prepare_row();
    walk_ = std::make_unique<SqliteWalk>(*database_, std::move(index), tell_reason);
  }

  /// Messages that nobody wants are not taken from the file.
  void prepare_row() {
    constexpr std::size_t kMostTerms = 64;
    std::string condition;
    std::size_t terms = 0;
    bool all = true;
    for (const auto& [id, topic] : by_id_) {
      all = all && wants_[topic];
      if (!wants_[topic]) continue;
      condition += (terms++ > 0 ? " OR topic_id=" : "topic_id=") + std::to_string(id);
    }
    std::string data = "data";
    if (terms == 0) {
      data = "NULL";
    } else if (!all && terms <= kMostTerms) {
      data = "CASE WHEN " + condition + " THEN data END";
    }
    row_ = std::make_unique<SqliteStatement>(
        *database_,
        "SELECT topic_id, timestamp, " + data + " FROM messages NOT INDEXED WHERE _rowid_ = ?1");
  }

  std::optional<RecordedMessage> read(std::int64_t row) {
    try {
      row_->reset();
      row_->bind(1, row);
      if (!row_->step()) {
        walk_->lose(row, "the index of times names it, but it is not there");
        return std::nullopt;
      }
    } catch (const SqliteError& error) {
      walk_->lose(row, error.what());
      return std::nullopt;
    }
    const auto topic = by_id_.find(row_->integer(0));
    if (topic == by_id_.end()) {
      tell_unknown(row_->integer(0));
      return std::nullopt;
    }
    if (!wants_[topic->second]) return std::nullopt;
    RecordedMessage message;
    message.topic = topic->second;
    message.recorded = {row_->integer(1)};
    message.bytes = row_->blob(2);
    message.place = {.at = row, .recorded = message.recorded, .size = message.bytes.size()};
    if (const auto fault = unpack(message.bytes)) {
      tell(fmt::format("message {} {}", row, *fault));
      return std::nullopt;
    }
    where_ = name_of(row);
    message.file = &where_;
    return message;
  }

  [[nodiscard]] std::string name_of(std::int64_t row) const {
    return fmt::format("{} (message {})", log_.name, row);
  }

  [[nodiscard]] std::span<const char> stored_at(const MessagePlace& place) {
    if (!placed_row_) {
      placed_row_ = std::make_unique<SqliteStatement>(
          *database_, "SELECT timestamp, data FROM messages NOT INDEXED WHERE _rowid_ = ?1");
    }
    placed_row_->reset();
    placed_row_->bind(1, place.at);
    if (!placed_row_->step()) throw_message_gone({where_});
    const std::span<const char> bytes = placed_row_->blob(1);
    if (placed_row_->integer(0) != place.recorded.nanoseconds || bytes.size() != place.size) {
      throw_message_gone({where_});
    }
    return bytes;
  }

  /// A message of CDR begins with other bytes: what looks like zstd is zstd, whatever metadata.yaml
  /// says. Why that can't be unpacked; nothing when it can.
  [[nodiscard]] std::optional<std::string> unpack(std::span<const char>& bytes) {
    if (!is_zstd({bytes.data(), bytes.size()})) return std::nullopt;
    try {
      unpacker_.unpack(bytes, most_message_bytes(), unpacked_);
      bytes = unpacked_;
      return std::nullopt;
    } catch (const std::bad_alloc&) {
      throw_too_large();
    } catch (const std::runtime_error& error) {
      return fmt::format("can't be unpacked ({})", error.what());
    }
  }

  void tell_unknown(std::int64_t id) {
    constexpr std::size_t kMostTold = 100;
    if (unknown_.size() >= kMostTold || !unknown_.insert(id).second) return;
    tell(fmt::format("messages of topic {} are left out: it is not in the table of topics", id));
  }

  SqliteLog log_;
  RecordingOptions options_;
  std::uint64_t file_bytes_ = 0;
  std::vector<std::string> notes_;
  std::unique_ptr<SqliteDatabase> database_;
  std::unique_ptr<SqliteStatement> row_;
  std::unique_ptr<SqliteStatement> placed_row_;
  std::unique_ptr<SqliteWalk> walk_;
  std::vector<RecordedTopic> topics_;
  std::map<std::int64_t, std::size_t> by_id_;
  std::vector<bool> wants_;
  std::set<std::int64_t> unknown_;
  ZstdUnpacker unpacker_;
  std::string unpacked_;
  std::string where_;
  std::int64_t last_row_ = 0;
  std::int64_t rows_ = 0;
  unsigned asked_ = 0;
  bool is_at_end_ = false;
};

}  // namespace

bool is_sqlite(std::string_view head) { return head.starts_with(kMagic); }

std::unique_ptr<Recording> open_sqlite_log(const SqliteLog& log, const RecordingOptions& options) {
  auto recording = std::make_unique<SqliteRecording>(log, options);
  recording->open_file();
  return recording;
}

std::unique_ptr<Recording> read_sqlite_log(std::string_view bytes,
                                           const RecordingOptions& options) {
  SqliteLog log{.path = {},
                .name = "memory",
                .stored_bytes = static_cast<std::int64_t>(bytes.size()),
                .packing = {}};
  auto recording = std::make_unique<SqliteRecording>(std::move(log), options);
  recording->open_bytes(bytes);
  return recording;
}

}  // namespace loopstone
