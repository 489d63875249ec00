#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "formats/recorded_topics.hpp"
#include "formats/recording.hpp"
#include "formats/stream_look.hpp"
#include "loopstone/formats/log_reader.hpp"

namespace loopstone {

/// Messages that come as a stream. There is no going back behind survey_is_over(), no index and no
/// bytes_at().
class StreamedRecording : public Recording {
 public:
  [[nodiscard]] const std::vector<RecordedTopic>& topics() const override { return topics_.all(); }
  [[nodiscard]] bool is_indexed() const override { return false; }
  void want(std::function<bool(const RecordedTopic&)> wanted) override {
    topics_.want(std::move(wanted));
  }
  [[nodiscard]] std::span<const char> bytes_at(const MessagePlace& place) override {
    throw_message_gone({name_, {}, place.at});
  }
  void rewind() override { look_.rewind(); }
  /// From the next rewind() on what was read is given once more, and forgotten then.
  void survey_is_over() { look_.end(); }

 protected:
  /// \param name    for messages
  /// \param look_s  see StreamLook
  StreamedRecording(std::string name, const RecordingOptions& options, std::optional<double> look_s)
      : name_(std::move(name)),
        options_(options),
        topics_(options.memory, 0, name_),
        look_(name_, look_s) {}

  std::string name_;
  RecordingOptions options_;
  RecordedTopics topics_;
  StreamLook look_;
};

using OpenStream = std::function<std::unique_ptr<StreamedRecording>(const RecordingOptions&)>;

/// As open_topic_log(). Pictures are left out: they are read when all else is done, and a stream
/// has gone by then.
[[nodiscard]] std::unique_ptr<LogReader> open_streamed_log(const std::string& format,
                                                           OpenStream open, LogOptions options);

}  // namespace loopstone
