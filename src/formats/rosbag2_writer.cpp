#include <fcntl.h>
#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <filesystem>
#include <map>
#include <system_error>
#include <utility>
#include <vector>

#include "formats/atomic_file.hpp"
#include "formats/recording_writer.hpp"
#include "formats/rosbag2_metadata.hpp"
#include "formats/sqlite_database.hpp"
#include "formats/written_stamps.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBytesOfTransaction = std::size_t{1} << 24;
constexpr const char* kMetadata = "metadata.yaml";

/// Version 4 of rosbag2's tables.
constexpr const char* kSchema =
    "CREATE TABLE schema(schema_version INTEGER PRIMARY KEY,ros_distro TEXT NOT NULL);"
    "CREATE TABLE metadata(id INTEGER PRIMARY KEY,metadata_version INTEGER NOT NULL,"
    "metadata TEXT NOT NULL);"
    "CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,"
    "serialization_format TEXT NOT NULL,offered_qos_profiles TEXT NOT NULL,"
    "type_description_hash TEXT NOT NULL);"
    "CREATE TABLE message_definitions(id INTEGER PRIMARY KEY,topic_type TEXT NOT NULL,"
    "encoding TEXT NOT NULL,encoded_message_definition TEXT NOT NULL,"
    "type_description_hash TEXT NOT NULL);"
    "CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,"
    "timestamp INTEGER NOT NULL, data BLOB NOT NULL);"
    "CREATE INDEX timestamp_idx ON messages (timestamp ASC);"
    "INSERT INTO schema(schema_version, ros_distro) VALUES (4, 'loopstone');";

/// Its name without a slash behind it, and with one of its own: "." has none.
fs::path named_folder(const std::string& folder) {
  fs::path path = fs::path(folder).lexically_normal();
  if (path.has_relative_path() && path.filename().empty()) path = path.parent_path();
  const fs::path name = path.filename();
  if (name.empty() || name == "." || name == "..") {
    throw UsageError("'" + folder + "' is no name for a new folder");
  }
  return path;
}

/// A folder that fills beside its place and is put there as a whole.
class WaitingFolder {
 public:
  WaitingFolder(fs::path target, std::vector<std::string> own_files)
      : target_(std::move(target)), own_files_(std::move(own_files)) {
    require_free_place();
    static std::atomic<unsigned> counter{0};
    std::error_code error;
    do {
      waiting_ = target_.parent_path() /
                 ("." + target_.filename().string() + "." + std::to_string(::getpid()) + "-" +
                  std::to_string(counter.fetch_add(1)) + ".partial");
    } while (!fs::create_directory(waiting_, error) && !error);
    if (error) fail("the folder can't be made: " + error.message());
  }
  WaitingFolder(const WaitingFolder&) = delete;
  WaitingFolder& operator=(const WaitingFolder&) = delete;
  ~WaitingFolder() {
    std::error_code ignored;
    if (!waiting_.empty()) fs::remove_all(waiting_, ignored);
  }

  [[nodiscard]] std::string file(const std::string& name) const {
    return (waiting_ / name).string();
  }
  [[noreturn]] void fail(const std::string& reason) const {
    throw DataError({target_.string()}, reason);
  }

  /// An earlier recording of this name gives way; nothing else does.
  void put_in_place() {
    require_free_place();
    for (const std::string& name : own_files_) sync(file(name));
    std::error_code error;
    const fs::path earlier = waiting_.string() + "-earlier.partial";
    const bool had_earlier = fs::exists(target_, error);
    if (had_earlier) fs::rename(target_, earlier, error);
    if (!error) fs::rename(waiting_, target_, error);
    if (error) {
      std::error_code ignored;
      if (had_earlier && fs::exists(earlier, ignored)) fs::rename(earlier, target_, ignored);
      fail("the folder can't be put in place: " + error.message());
    }
    waiting_.clear();
    if (had_earlier) fs::remove_all(earlier, error);
  }

 private:
  void require_free_place() const {
    std::error_code error;
    const auto status = fs::symlink_status(target_, error);
    if (!fs::exists(status)) return;
    if (!fs::is_directory(status)) fail("cannot be made into a folder: it is a file");
    for (fs::directory_iterator entry(target_, error), end; !error && entry != end;
         entry.increment(error)) {
      const std::string name = entry->path().filename().string();
      if (std::find(own_files_.begin(), own_files_.end(), name) != own_files_.end()) continue;
      fail("the folder holds something else ('" + name + "'); give the name of a new one");
    }
    if (error) fail("cannot look into this folder: " + error.message());
  }

  /// Full disks are found out before anything appears.
  void sync(const std::string& path) const {
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    const bool is_synced = descriptor >= 0 && (::fsync(descriptor) == 0 || errno == EINVAL);
    const int error_number = errno;
    if (descriptor >= 0) ::close(descriptor);
    if (!is_synced) fail("cannot be written: " + std::generic_category().message(error_number));
  }

  fs::path target_;
  std::vector<std::string> own_files_;
  fs::path waiting_;
};

class Rosbag2Writer final : public RecordingWriter {
 public:
  explicit Rosbag2Writer(const fs::path& folder)
      : path_(folder.string()),
        file_name_(folder.filename().string() + "_0.db3"),
        folder_(folder, {file_name_, kMetadata}) {
    guarded([this] {
      database_ = std::make_unique<SqliteDatabase>(folder_.file(file_name_),
                                                   SqliteOptions{.access = SqliteAccess::kCreate});
      database_->run("BEGIN");
      database_->run(kSchema);
      add_ = std::make_unique<SqliteStatement>(
          *database_, "INSERT INTO messages (timestamp, topic_id, data) VALUES (?1, ?2, ?3)");
    });
  }

  WireFormat wire_format() const override { return WireFormat::kCdr; }

  std::size_t add_topic(const WrittenTopic& topic) override {
    const std::string type = ros2_type(topic.type);
    guarded([&] {
      insert(
          "INSERT INTO topics (name, type, serialization_format, offered_qos_profiles, "
          "type_description_hash) VALUES (?1, ?2, ?3, ?4, ?5)",
          {topic.name, type, "cdr", format_qos_profiles(topic.latched), topic.rihs01});
      if (!types_.emplace(type + topic.rihs01, true).second) return;
      insert(
          "INSERT INTO message_definitions (topic_type, encoding, "
          "encoded_message_definition, type_description_hash) VALUES (?1, ?2, ?3, ?4)",
          {type, "ros2msg", topic.ros2_definition, topic.rihs01});
    });
    contents_.topics.push_back({topic.name, type, topic.rihs01, topic.latched, 0});
    return contents_.topics.size() - 1;
  }

  void write(std::size_t topic, Stamp recorded, std::span<const char> bytes) override {
    (void)written_nanoseconds(recorded, path_);
    ++contents_.topics.at(topic).messages;
    guarded([&] {
      add_->reset();
      add_->bind(1, recorded.nanoseconds);
      add_->bind(2, static_cast<std::int64_t>(topic + 1));
      add_->bind_blob(3, bytes);
      (void)add_->step();
      add_->reset();
      waiting_bytes_ += bytes.size();
      if (waiting_bytes_ >= kBytesOfTransaction) {
        database_->run("COMMIT; BEGIN");
        waiting_bytes_ = 0;
      }
    });
    const bool is_first = contents_.messages++ == 0;
    contents_.first = is_first ? recorded : std::min(contents_.first, recorded);
    contents_.last = is_first ? recorded : std::max(contents_.last, recorded);
  }

  void finish() override {
    contents_.storage = "sqlite3";
    contents_.file = file_name_;
    guarded([this] {
      insert("INSERT INTO metadata (metadata_version, metadata) VALUES (9, ?1)",
             {format_inner_rosbag2_metadata(contents_)});
      database_->run("COMMIT");
    });
    add_.reset();
    database_.reset();
    write_file_atomically(folder_.file(kMetadata), format_rosbag2_metadata(contents_));
    folder_.put_in_place();
  }

 private:
  /// Errors of SQLite as those of the file.
  template <typename Action>
  void guarded(const Action& action) const {
    try {
      action();
    } catch (const SqliteError& error) {
      throw DataError({path_}, "cannot be written: " + std::string(error.what()));
    }
  }

  void insert(const std::string& sql, const std::vector<std::string>& texts) {
    SqliteStatement statement(*database_, sql);
    for (std::size_t i = 0; i < texts.size(); ++i) {
      statement.bind_text(static_cast<int>(i + 1), texts[i]);
    }
    (void)statement.step();
  }

  std::string path_;
  std::string file_name_;
  WaitingFolder folder_;
  std::unique_ptr<SqliteDatabase> database_;
  std::unique_ptr<SqliteStatement> add_;
  std::map<std::string, bool> types_;
  Rosbag2Contents contents_;
  std::size_t waiting_bytes_ = 0;
};

}  // namespace

std::unique_ptr<RecordingWriter> create_rosbag2(const std::string& folder) {
  if (folder.empty()) throw UsageError("the name of an output folder is empty");
  return std::make_unique<Rosbag2Writer>(named_folder(folder));
}

}  // namespace loopstone
