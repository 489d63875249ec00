#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "formats/recording_writer.hpp"
#include "loopstone/base/stamp.hpp"
#include "loopstone/messages/message_codec.hpp"

namespace loopstone {

/// Messages of the types that are known here, each to its topic, which its first message makes.
class TopicWriter {
 public:
  explicit TopicWriter(std::unique_ptr<RecordingWriter> writer) : writer_(std::move(writer)) {}

  /// \param latched  who comes late gets the last message; the first message of a topic says it
  template <typename M>
  void send(const std::string& topic, Stamp recorded, const M& message, bool latched = false) {
    auto known = topics_.find(topic);
    if (known == topics_.end()) {
      const std::size_t number = writer_->add_topic(written_topic<M>(topic, latched));
      known = topics_.emplace(topic, number).first;
    }
    encode_message(writer_->wire_format(), message, bytes_);
    writer_->write(known->second, recorded, bytes_);
  }
  void finish() { writer_->finish(); }

 private:
  std::unique_ptr<RecordingWriter> writer_;
  std::map<std::string, std::size_t> topics_{};
  std::string bytes_{};
};

}  // namespace loopstone
