#include <algorithm>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/topic_log.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "refusal.hpp"

// Wheels of a recording. The first byte picks the serialisation (lowest bit) and the language of
// the definition (the next two). Topic, type and definition follow, each up to a byte of 0; then
// messages of the topic, each behind two bytes with its length, 50 ms after one another.
namespace {

using namespace loopstone;

std::string cut(std::string_view& text) {
  const std::string head(text.substr(0, text.find('\0')));
  text.remove_prefix(std::min(text.size(), head.size() + 1));
  return head;
}

class OneTopic final : public Recording {
 public:
  explicit OneTopic(std::string_view text) {
    RecordedTopic topic;
    const unsigned how = text.empty() ? 0U : static_cast<unsigned char>(text[0]);
    text.remove_prefix(std::min<std::size_t>(1, text.size()));
    topic.format = (how & 1) == 0 ? WireFormat::kCdr : WireFormat::kRos1;
    topic.definition.language = static_cast<DefinitionLanguage>(how >> 1 & 3);
    topic.name = cut(text);
    topic.type = cut(text);
    topic.definition.text = cut(text);
    topics_.push_back(topic);
    while (text.size() >= 2) {
      std::uint16_t length = 0;
      std::memcpy(&length, text.data(), sizeof length);
      text.remove_prefix(sizeof length);
      messages_.push_back(text.substr(0, length));
      text.remove_prefix(messages_.back().size());
    }
  }
  const std::vector<RecordedTopic>& topics() const override { return topics_; }
  bool is_indexed() const override { return true; }
  void want(std::function<bool(const RecordedTopic&)> wanted) override {
    is_wanted_ = !wanted || wanted(topics_[0]);
  }
  std::optional<RecordedMessage> next() override {
    if (!is_wanted_ || next_ == messages_.size()) return std::nullopt;
    const Stamp stamp = Stamp{1'700'000'000'000'000'000} +
                        Duration::from_milliseconds(50 * static_cast<std::int64_t>(next_));
    return RecordedMessage{.topic = 0, .recorded = stamp, .bytes = messages_[next_++]};
  }
  std::span<const char> bytes_at(const MessagePlace& place) override {
    throw_message_gone({std::to_string(place.at)});
  }
  void rewind() override { next_ = 0; }
  ReadProgress progress() const override { return {}; }

 private:
  std::vector<RecordedTopic> topics_{};
  std::vector<std::string_view> messages_{};
  std::size_t next_ = 0;
  bool is_wanted_ = true;
};

void read(std::string_view text, const StatedWheels& wheels) {
  const auto log = open_topic_log(
      "wheels", [&](const RecordingOptions&) { return std::make_unique<OneTopic>(text); },
      {.topics = {.wheels = wheels}});
  std::optional<Stamp> last;  // stamps may be negative
  while (const auto message = log->next()) {
    if (last && stamp_of(*message) < *last) __builtin_trap();
    last = stamp_of(*message);
  }
  (void)log->notes();
  (void)log->warnings();
  (void)log->topics();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text = fuzz::text_of(data, size);
  return fuzz::expect_work_or_refusal(text, [&] {
    StatedWheels wheels{.metres_per_count = 1e-3, .radius_m = 0.1, .track_width_m = 0.5};
    read(text, wheels);
    wheels.counts_are_cumulative = false;
    wheels.counter_bits = 12;
    read(text, wheels);
    read(text, {});
  });
}
