#include "loopstone/formats/message_log.hpp"

#include <cstdint>
#include <utility>

#include "formats/mcap_stream.hpp"
#include "formats/recorded_topics.hpp"
#include "formats/recording.hpp"
#include "formats/stream_look.hpp"
#include "formats/topic_log.hpp"

namespace loopstone {
namespace {

class CameMessages final : public StreamedRecording {
 public:
  CameMessages(std::string name, TakeMessage take, const RecordingOptions& options, double look_s)
      : name_(std::move(name)),
        take_(std::move(take)),
        options_(options),
        topics_(options.memory, 0, name_),
        look_(name_, look_s) {}

  [[nodiscard]] const std::vector<RecordedTopic>& topics() const override { return topics_.all(); }
  [[nodiscard]] bool is_indexed() const override { return false; }
  void want(std::function<bool(const RecordedTopic&)> wanted) override {
    topics_.want(std::move(wanted));
  }
  [[nodiscard]] std::optional<RecordedMessage> next() override;
  [[nodiscard]] std::span<const char> bytes_at(const MessagePlace& place) override {
    throw_message_gone({name_, {}, place.at});
  }
  void rewind() override { look_.rewind(); }
  void survey_is_over() override { look_.end(); }
  [[nodiscard]] ReadProgress progress() const override { return {bytes_, 0}; }

 private:
  std::string name_;
  TakeMessage take_;
  RecordingOptions options_;
  RecordedTopics topics_;
  StreamLook look_;
  CameMessage in_use_{};
  std::int64_t bytes_ = 0;
};

std::optional<RecordedMessage> CameMessages::next() {
  while (true) {
    if (auto kept = look_.next_kept(topics_)) return kept;
    if (options_.stop && options_.stop()) throw ReadingStopped();
    if (look_.is_enough()) return {};
    auto came = take_();
    if (!came) continue;
    in_use_ = std::move(*came);
    bytes_ += static_cast<std::int64_t>(in_use_.bytes.size());
    const std::size_t topic = topics_.add({.name = in_use_.topic, .type = in_use_.type});
    const RecordedMessage message{.topic = topic,
                                  .recorded = in_use_.received,
                                  .bytes = in_use_.bytes,
                                  .file = &in_use_.topic};
    look_.take(message, topics_);
    if (!look_.is_on() && topics_.is_wanted(topic)) return message;
  }
}

}  // namespace

std::unique_ptr<LogReader> open_message_log(const std::string& name, TakeMessage take,
                                            const LogOptions& options) {
  LogOptions how = options;
  if (!how.live) how.live.emplace();
  how.topics.pictures = false;
  const auto stream = std::make_shared<StreamedRecording*>(nullptr);
  auto reader = open_topic_log(
      "ros2",
      [stream, name, take = std::move(take),
       look_s = how.live->look_s](const RecordingOptions& recording) {
        auto opened = std::make_unique<CameMessages>(name, take, recording, look_s);
        *stream = opened.get();
        return opened;
      },
      how);
  (*stream)->survey_is_over();
  return reader;
}

}  // namespace loopstone
