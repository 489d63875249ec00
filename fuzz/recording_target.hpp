#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/recording.hpp"
#include "refusal.hpp"

namespace loopstone::fuzz {

/// Some messages of a recording, to be asked for again by their places.
class PlacedMessages {
 public:
  void add(const RecordedMessage& message) {
    constexpr std::size_t kMost = 64;
    constexpr std::size_t kMostBytes = std::size_t{1} << 16;
    if (kept_.size() >= kMost || message.bytes.size() > kMostBytes) return;
    kept_.emplace_back(message.place, std::string(message.bytes.begin(), message.bytes.end()));
  }

  /// \param may_refuse  whether a message that was given may be found damaged the next time
  void ask(Recording& recording, bool may_refuse) {
    std::reverse(kept_.begin(), kept_.end());
    for (const auto& [place, bytes] : kept_) {
      try {
        if (!std::ranges::equal(recording.bytes_at(place), bytes)) __builtin_trap();
      } catch (const DataError&) {
        if (!may_refuse) __builtin_trap();
      }
      try {
        MessagePlace other = place;
        other.at += 1 + static_cast<std::int64_t>(bytes.size() % 7);
        (void)recording.bytes_at(other);
      } catch (const DataError&) {
        continue;  // as it should be, mostly
      }
    }
  }

 private:
  std::vector<std::pair<MessagePlace, std::string>> kept_{};
};

/// Reads a recording to its end, all of it and then the first topic alone; some messages once more
/// by their places.
template <typename Open>
void use_recording(std::string_view bytes, Open&& open) {
  RecordingOptions options;
  options.on_damage = [](const Problem& problem) {
    if (problem.reason.empty()) __builtin_trap();
  };
  const std::unique_ptr<Recording> recording = open(bytes, options);
  PlacedMessages placed;
  while (const auto message = recording->next()) {
    if (message->topic >= recording->topics().size()) __builtin_trap();
    placed.add(*message);
  }
  placed.ask(*open(bytes, RecordingOptions{}), false);
  (void)recording->notes();
  (void)recording->progress();
  if (recording->topics().empty()) return;
  const std::string first = recording->topics()[0].name;
  recording->want([&](const RecordedTopic& topic) { return topic.name == first; });
  recording->rewind();
  while (const auto message = recording->next()) {
    if (recording->topics()[message->topic].name != first) __builtin_trap();
  }
}

}  // namespace loopstone::fuzz
