#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/recorded_topics.hpp"
#include "formats/recording.hpp"

namespace loopstone {

/// A look at the beginning of a stream, in which there is no going back: what is read meanwhile is
/// kept, to be given again, and for a last time when the look is over.
class StreamLook {
 public:
  using Clock = std::chrono::steady_clock;

  /// \param name    the stream's, for messages
  /// \param look_s  so long after the first message, once a laser's was among them, whoever looks
  ///                has seen enough; nothing: the end of the stream alone is the end
  StreamLook(std::string name, std::optional<double> look_s)
      : name_(std::move(name)), look_s_(look_s) {}

  /// Every message that is read from the stream. While the look is on it is kept, and comes by
  /// next_kept() if it is wanted; those that are not wanted are kept all the same: somebody else
  /// may want them.
  void take(const RecordedMessage& message, const RecordedTopics& topics);
  /// The next wanted one of those that were kept.
  [[nodiscard]] std::optional<RecordedMessage> next_kept(const RecordedTopics& topics);
  void rewind() { at_kept_ = 0; }
  void end() { is_on_ = false; }

  [[nodiscard]] bool is_on() const { return is_on_; }
  /// When whoever looks is told that there is no more.
  [[nodiscard]] std::optional<Clock::time_point> until() const;
  [[nodiscard]] bool is_enough() const {
    const auto last = until();
    return last && Clock::now() > *last;
  }

 private:
  struct Kept {
    std::size_t topic = 0;
    Stamp recorded{};
    std::int64_t offset = 0;
    std::vector<char> bytes{};
  };

  std::string name_;
  std::optional<double> look_s_;
  bool is_on_ = true;
  std::deque<Kept> kept_{};
  std::size_t at_kept_ = 0;
  Kept in_use_{};
  std::optional<Clock::time_point> first_{};  ///< when the first message came
  bool has_laser_ = false;
};

}  // namespace loopstone
