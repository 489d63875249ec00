#include "loopstone/formats/message_log.hpp"

#include <cstdint>
#include <utility>

#include "formats/streamed_recording.hpp"

namespace loopstone {
namespace {

class CameMessages final : public StreamedRecording {
 public:
  CameMessages(std::string name, TakeMessage take, const RecordingOptions& options, double look_s)
      : StreamedRecording(std::move(name), options, look_s), take_(std::move(take)) {}

  [[nodiscard]] std::optional<RecordedMessage> next() override;
  [[nodiscard]] ReadProgress progress() const override { return {bytes_, 0}; }

 private:
  TakeMessage take_;
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
  return open_streamed_log(
      "ros2",
      [name, take = std::move(take), look_s = how.live->look_s](const RecordingOptions& recording) {
        return std::make_unique<CameMessages>(name, take, recording, look_s);
      },
      how);
}

}  // namespace loopstone
