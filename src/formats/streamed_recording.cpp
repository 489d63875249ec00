#include "formats/streamed_recording.hpp"

#include "formats/topic_log.hpp"

namespace loopstone {

std::unique_ptr<LogReader> open_streamed_log(const std::string& format, OpenStream open,
                                             LogOptions options) {
  options.topics.pictures = false;
  const auto stream = std::make_shared<StreamedRecording*>(nullptr);
  auto reader = open_topic_log(
      format,
      [stream, open = std::move(open)](const RecordingOptions& recording) {
        auto opened = open(recording);
        *stream = opened.get();
        return opened;
      },
      options);
  (*stream)->survey_is_over();
  return reader;
}

}  // namespace loopstone
