#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "formats/recording.hpp"

namespace loopstone {

/// The topics of a recording as they are found, and which of them are wanted. What they take is
/// held to the budget of the file, since a packed file can hold more definitions than it has bytes.
class RecordedTopics {
 public:
  RecordedTopics(const MemoryBudget& memory, std::uint64_t file_bytes, std::string file);

  /// The number of this topic: of an equal one that is there, else of a new one. Throws DataError
  /// when there are too many.
  std::size_t add(RecordedTopic topic);
  /// Takes note of memory that is held beside the topics. Throws DataError when it is too much.
  void hold(std::uint64_t bytes);
  void count(std::size_t topic, std::int64_t messages);

  [[nodiscard]] const std::vector<RecordedTopic>& all() const { return topics_; }
  void want(std::function<bool(const RecordedTopic&)> wanted);
  [[nodiscard]] bool is_wanted(std::size_t topic) const { return wanted_[topic] != 0; }
  [[nodiscard]] bool wants_all() const { return !want_; }

 private:
  MemoryBudget memory_;
  std::uint64_t file_bytes_;
  std::string file_;
  std::uint64_t held_bytes_ = 0;
  std::vector<RecordedTopic> topics_{};
  std::unordered_multimap<std::size_t, std::size_t> by_hash_{};
  std::vector<char> wanted_{};
  std::function<bool(const RecordedTopic&)> want_{};
};

/// Tells of damage that was passed, each once, however often a recording is read.
class ToldDamage {
 public:
  ToldDamage(std::function<void(const Problem&)> on_damage, std::string file)
      : on_damage_(std::move(on_damage)), file_(std::move(file)) {}

  void tell(std::uint64_t offset, const std::string& reason) {
    if (known_.contains(offset)) return;
    constexpr std::size_t kMostRemembered = std::size_t{1} << 18;
    if (fresh_.size() < kMostRemembered) fresh_.insert(offset);
    if (on_damage_) on_damage_({{file_, {}, static_cast<std::int64_t>(offset)}, reason});
  }
  /// The recording is read once more.
  void begin_again() { known_.merge(fresh_); }

 private:
  std::function<void(const Problem&)> on_damage_;
  std::string file_;
  std::unordered_set<std::uint64_t> known_{};  ///< where damage was when it was read before
  std::unordered_set<std::uint64_t> fresh_{};
};

}  // namespace loopstone
