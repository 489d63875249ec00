#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "formats/recording.hpp"
#include "formats/rosbag2_folder.hpp"
#include "formats/sqlite_recording.hpp"
#include "formats/temporary_folder.hpp"
#include "formats/zstd_unpack.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

std::string head_of(const std::string& path) {
  std::string head(16, '\0');
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (file == nullptr) {
    throw DataError({path}, "cannot open this file: " + std::generic_category().message(errno));
  }
  head.resize(std::fread(head.data(), 1, head.size(), file));
  std::fclose(file);
  return head;
}

Problem problem_of(const DataError& error) {
  std::string reason = error.what();
  const std::string where = to_string(error.location()) + ": ";
  if (reason.starts_with(where)) reason.erase(0, where.size());
  return {error.location(), reason};
}

std::int64_t size_of(const std::string& path) {
  std::error_code error;
  const auto bytes = fs::file_size(path, error);
  return error ? 0 : static_cast<std::int64_t>(bytes);
}

/// A file that is read from an unpacked copy: what it says of itself is said of the packed one.
class UnpackedRecording final : public Recording {
 public:
  UnpackedRecording(std::string name, const RecordingOptions& options)
      : name_(std::move(name)), options_(options) {}

  void open(const std::string& packing) {
    const auto stored = static_cast<std::uint64_t>(size_of(name_));
    // Honest recordings become some ten times as large; disks have an end, too.
    constexpr std::uint64_t kKeptFree = std::uint64_t{1} << 26;
    const std::uintmax_t room = folder_.free_bytes();
    MemoryBudget budget = options_.memory;
    if (budget.by_file_size) budget.ceiling_bytes = std::numeric_limits<std::uint64_t>::max();
    const std::uint64_t most = std::min<std::uint64_t>(
        budget.allowed_bytes(stored, Growth::kNumbers), room > kKeptFree ? room - kKeptFree : room);
    const std::string copy = folder_ / "recording";
    const UnpackedFile unpacked = unpack_zstd_file(name_, copy, most, options_.stop);
    notes_.push_back(fmt::format("{} was unpacked into a temporary file of {}", name_,
                                 bytes_text(unpacked.bytes)));
    if (!unpacked.damage.empty() && options_.on_damage) {
      options_.on_damage({{name_}, "can't be unpacked as a whole: " + unpacked.damage});
    }
    if (unpacked.bytes == 0) throw DataError({name_}, "nothing in this file can be unpacked");
    const bool is_database = is_sqlite(head_of(copy));
    if (is_database || without_packing().ends_with(".db3")) {
      inner_ = open_sqlite_log({copy, name_, size_of(name_), packing}, options_);
      folder_.remove();
      return;
    }
    RecordingOptions inner = options_;
    inner.on_damage = [this](const Problem& problem) {
      if (!options_.on_damage) return;
      Problem renamed = problem;
      renamed.location.path = name_;
      options_.on_damage(renamed);
    };
    is_renamed_ = true;
    inner_ = open_mcap(copy, inner);
  }

  const std::vector<RecordedTopic>& topics() const override { return inner_->topics(); }
  bool is_indexed() const override { return inner_->is_indexed(); }
  void want(std::function<bool(const RecordedTopic&)> wanted) override {
    inner_->want(std::move(wanted));
  }
  std::optional<RecordedMessage> next() override {
    auto message = inner_->next();
    if (message && is_renamed_) message->file = &name_;
    return message;
  }
  std::span<const char> bytes_at(const MessagePlace& place) override {
    try {
      return inner_->bytes_at(place);
    } catch (const DataError& error) {
      if (!is_renamed_) throw;
      Problem problem = problem_of(error);
      problem.location.path = name_;
      throw DataError(problem.location, problem.reason);
    }
  }
  void rewind() override { inner_->rewind(); }
  ReadProgress progress() const override {
    const ReadProgress inner = inner_->progress();
    ReadProgress progress{0, size_of(name_)};
    if (inner.bytes_total > 0) {
      const double share =
          static_cast<double>(inner.bytes_done) / static_cast<double>(inner.bytes_total);
      progress.bytes_done =
          static_cast<std::int64_t>(static_cast<double>(progress.bytes_total) * share);
    }
    return progress;
  }
  std::vector<std::string> notes() const override {
    std::vector<std::string> all = notes_;
    const auto inner = inner_->notes();
    all.insert(all.end(), inner.begin(), inner.end());
    return all;
  }

 private:
  [[nodiscard]] std::string_view without_packing() const {
    constexpr std::string_view kPacked = ".zstd";
    std::string_view name = name_;
    if (name.ends_with(kPacked)) name.remove_suffix(kPacked.size());
    return name;
  }

  std::string name_;
  RecordingOptions options_;
  TemporaryFolder folder_;
  std::vector<std::string> notes_;
  bool is_renamed_ = false;
  std::unique_ptr<Recording> inner_;
};

std::unique_ptr<Recording> open_split(const std::string& path, const std::string& packing,
                                      const RecordingOptions& options) {
  const std::string head = head_of(path);
  if (is_zstd(head)) {
    auto recording = std::make_unique<UnpackedRecording>(path, options);
    recording->open(packing);
    return recording;
  }
  if (!is_sqlite(head) && path.ends_with(".mcap")) return open_mcap(path, options);
  return open_sqlite_log({path, path, size_of(path), packing}, options);
}

/// One or several files, one after the other.
class Rosbag2Recording final : public Recording {
 public:
  Rosbag2Recording(const std::string& path, const RecordingOptions& options)
      : path_(path), options_(options), on_damage_(std::move(options_.on_damage)) {
    options_.on_damage = [this](const Problem& problem) { tell(problem); };
    std::error_code ignored;
    is_folder_ = fs::is_directory(path, ignored);
    if (is_folder_) {
      look_into_folder();
    } else {
      files_.push_back(path);
    }
    for (const std::string& file : files_) bytes_.push_back(size_of(file));
    open_all();
    set_counts();
  }

  const std::vector<RecordedTopic>& topics() const override { return topics_; }
  bool is_indexed() const override { return is_indexed_; }

  void want(std::function<bool(const RecordedTopic&)> wanted) override {
    wanted_ = std::move(wanted);
    decisions_.clear();
    apply_wants();
  }

  std::optional<RecordedMessage> next() override {
    while (file_ < files_.size()) {
      if (!current_ && !open_current()) {
        ++file_;
        continue;
      }
      if (auto message = next_of_current()) {
        if (const auto fault = unpack(message->bytes, file_)) {
          tell({message->where(), *fault});
          continue;
        }
        message->topic = global_topic(message->topic);
        message->place.file = file_;
        return message;
      }
      take_notes();
      learn_topics();
      if (file_ + 1 == files_.size()) break;  // kept for the next time
      current_.reset();
      ++file_;
    }
    is_at_end_ = true;
    return std::nullopt;
  }

  std::span<const char> bytes_at(const MessagePlace& place) override {
    if (place.file >= files_.size()) throw_message_gone({path_});
    std::span<const char> bytes = file_for(place).bytes_at(place);
    if (const auto fault = unpack(bytes, place.file)) {
      throw DataError({files_[place.file], {}, place.at}, *fault);
    }
    return bytes;
  }

  void rewind() override {
    is_at_end_ = false;
    if (current_ && file_ == 0) return current_->rewind();
    current_.reset();
    file_ = 0;
  }

  ReadProgress progress() const override {
    ReadProgress progress;
    for (std::size_t i = 0; i < bytes_.size(); ++i) {
      if (i < file_ || is_at_end_) progress.bytes_done += bytes_[i];
      progress.bytes_total += bytes_[i];
    }
    if (!is_at_end_ && current_) progress.bytes_done += current_->progress().bytes_done;
    return progress;
  }

  std::vector<std::string> notes() const override {
    std::vector<std::string> all = notes_;
    if (!current_) return all;
    for (std::string& note : current_->notes()) {
      if (std::find(all.begin(), all.end(), note) == all.end()) all.push_back(std::move(note));
    }
    return all;
  }

 private:
  void tell(const Problem& problem) {
    // Files are opened more than once; what was told is not told again.
    constexpr std::size_t kMost = std::size_t{1} << 20;
    const std::size_t mark = std::hash<std::string>{}(to_string(problem.location) + problem.reason);
    if (told_.size() < kMost && told_.insert(mark).second && on_damage_) on_damage_(problem);
  }

  void look_into_folder() {
    Rosbag2Folder folder = look_at_rosbag2_folder(path_);
    for (const Problem& problem : folder.problems) tell(problem);
    for (const std::string& missing : folder.missing) {
      tell({{path_}, "'" + missing + "' is missing, which metadata.yaml lists"});
    }
    if (folder.files.empty()) {
      throw DataError({path_}, folder.missing.empty()
                                   ? "holds no recording of rosbag2 (no .db3 and no .mcap)"
                                   : "none of the files that its metadata.yaml lists is there");
    }
    files_ = std::move(folder.files);
    notes_ = std::move(folder.notes);
    if (!folder.metadata) return;
    counts_ = std::move(folder.metadata->messages);
    if (folder.metadata->compression_mode == "message") {
      packing_ = folder.metadata->compression_format;
    }
  }

  /// Learns the topics of all files that need not be unpacked for it, and stays at the first.
  void open_all() {
    if (!is_folder_) {
      current_ = open_split(files_[0], packing_, options_);
      begin_current();
      is_indexed_ = current_->is_indexed();
      return;
    }
    std::optional<DataError> failure;
    std::size_t opened = 0;
    is_indexed_ = true;
    for (file_ = 0; file_ < files_.size(); ++file_) {
      try {
        if (opened > 0 && is_zstd(head_of(files_[file_]))) {
          is_indexed_ = false;
          continue;
        }
        auto recording = open_split(files_[file_], packing_, options_);
        current_ = std::move(recording);
        begin_current();
        is_indexed_ = is_indexed_ && current_->is_indexed();
        ++opened;
      } catch (const DataError& error) {
        tell(problem_of(error));
        failure = error;
      }
    }
    if (opened == 0) throw DataError(*failure);
    if (files_.size() > 1) current_.reset();
    file_ = 0;
  }

  void set_counts() {
    std::map<std::string, int> entries;
    for (const RecordedTopic& topic : topics_) ++entries[topic.name];
    for (RecordedTopic& topic : topics_) {
      const auto count = counts_.find(topic.name);
      if (topic.messages || count == counts_.end() || entries[topic.name] != 1) continue;
      topic.messages = count->second;
    }
  }

  [[nodiscard]] bool open_current() {
    try {
      current_ = open_split(files_[file_], packing_, options_);
      begin_current();
      return true;
    } catch (const DataError& error) {
      tell(problem_of(error));
      return false;
    }
  }

  void begin_current() {
    of_current_.clear();
    learn_topics();
    apply_wants();
  }

  [[nodiscard]] std::optional<RecordedMessage> next_of_current() {
    try {
      return current_->next();
    } catch (const DataError& error) {
      if (!is_folder_) throw;
      tell(problem_of(error));
      return std::nullopt;
    }
  }

  /// The file that is read at the moment, or another one that is kept beside it.
  [[nodiscard]] Recording& file_for(const MessagePlace& place) {
    if (current_ && place.file == file_) return *current_;
    if (!placed_ || placed_file_ != place.file) {
      placed_.reset();
      placed_ = open_split(files_[place.file], packing_, options_);
      placed_file_ = place.file;
    }
    return *placed_;
  }

  /// A message that is packed by itself within MCAP; databases unpack theirs. Why that can't be
  /// done; nothing when it can.
  [[nodiscard]] std::optional<std::string> unpack(std::span<const char>& bytes, std::size_t file) {
    if (packing_ != "zstd" || !is_zstd({bytes.data(), bytes.size()})) return std::nullopt;
    const auto stored = static_cast<std::uint64_t>(bytes_[file]);
    try {
      unpacker_.unpack(bytes, options_.memory.allowed_bytes(stored, Growth::kNumbers), unpacked_);
      bytes = unpacked_;
      return std::nullopt;
    } catch (const std::runtime_error& error) {
      return fmt::format("this message can't be unpacked ({})", error.what());
    }
  }

  void take_notes() {
    for (std::string& note : current_->notes()) {
      if (std::find(notes_.begin(), notes_.end(), note) == notes_.end()) {
        notes_.push_back(std::move(note));
      }
    }
  }

  void apply_wants() {
    if (!current_) return;
    if (!wanted_) return current_->want({});
    current_->want([this](const RecordedTopic& topic) {
      const std::size_t number = number_of(topic);
      const auto decided = decisions_.find(number);
      if (decided != decisions_.end()) return decided->second;
      return decisions_[number] = wanted_(topics_[number]);
    });
  }

  void learn_topics() {
    const auto& topics = current_->topics();
    while (of_current_.size() < topics.size()) {
      const RecordedTopic& topic = topics[of_current_.size()];
      const std::size_t number = number_of(topic);
      const bool is_first_pass = learnt_.insert({file_, of_current_.size()}).second;
      if (is_first_pass && topic.messages) {
        topics_[number].messages = topics_[number].messages.value_or(0) + *topic.messages;
      }
      of_current_.push_back(number);
    }
  }

  [[nodiscard]] std::size_t global_topic(std::size_t topic) {
    learn_topics();
    return of_current_.at(topic);
  }

  /// Of the entry that says the same; it is added when there is none.
  [[nodiscard]] std::size_t number_of(const RecordedTopic& topic) {
    const auto [begin, end] = by_name_.equal_range(topic.name);
    for (auto entry = begin; entry != end; ++entry) {
      const RecordedTopic& known = topics_[entry->second];
      if (known.type == topic.type && known.format == topic.format && known.hash == topic.hash &&
          known.unreadable == topic.unreadable &&
          known.definition.language == topic.definition.language &&
          known.definition.text == topic.definition.text) {
        return entry->second;
      }
    }
    topics_.push_back(topic);
    topics_.back().messages.reset();  // counted in learn_topics()
    by_name_.emplace(topic.name, topics_.size() - 1);
    return topics_.size() - 1;
  }

  std::string path_;
  RecordingOptions options_;
  std::function<void(const Problem&)> on_damage_;
  std::set<std::size_t> told_;
  bool is_folder_ = false;
  bool is_indexed_ = false;
  bool is_at_end_ = false;
  std::vector<std::string> files_;
  std::vector<std::int64_t> bytes_;
  std::vector<std::string> notes_;
  std::string packing_;
  std::map<std::string, std::int64_t, std::less<>> counts_;
  std::vector<RecordedTopic> topics_;
  std::multimap<std::string, std::size_t> by_name_;
  std::set<std::pair<std::size_t, std::size_t>> learnt_;  // file, topic in it
  std::function<bool(const RecordedTopic&)> wanted_;
  std::map<std::size_t, bool> decisions_;
  std::size_t file_ = 0;
  std::unique_ptr<Recording> current_;
  std::size_t placed_file_ = 0;
  std::unique_ptr<Recording> placed_;  ///< of bytes_at(), where it is not the current one
  std::vector<std::size_t> of_current_;
  ZstdUnpacker unpacker_;
  std::string unpacked_;  ///< of the last message
};

}  // namespace

std::unique_ptr<Recording> open_rosbag2(const std::string& path, const RecordingOptions& options) {
  return std::make_unique<Rosbag2Recording>(path, options);
}

std::vector<std::string> rosbag2_files(const std::string& folder) {
  return look_at_rosbag2_folder(folder).files;
}

}  // namespace loopstone
