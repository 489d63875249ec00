#pragma once

#include <memory>
#include <string_view>

#include "formats/recording.hpp"
#include "refusal.hpp"

namespace loopstone::fuzz {

/// Reads a recording to its end, all of it and then the first topic alone.
template <typename Open>
void use_recording(std::string_view bytes, Open&& open) {
  RecordingOptions options;
  options.on_damage = [](const Problem& problem) {
    if (problem.reason.empty()) __builtin_trap();
  };
  const std::unique_ptr<Recording> recording = open(bytes, options);
  while (const auto message = recording->next()) {
    if (message->topic >= recording->topics().size()) __builtin_trap();
  }
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
