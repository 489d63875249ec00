#pragma once

#include <cstddef>
#include <map>
#include <tuple>

#include "formats/recording.hpp"
#include "loopstone/messages/message_codec.hpp"

namespace loopstone {

/// Decodes the messages of a recording's topics, each by its own definition.
class TopicDecoders {
 public:
  explicit TopicDecoders(const Recording& recording) : recording_(&recording) {}

  /// Memory of `value` is used again. Throws MessageError.
  template <typename M>
  void decode(const RecordedMessage& message, M& value) {
    auto& known = std::get<Decoders<M>>(decoders_);
    auto found = known.find(message.topic);
    if (found == known.end()) {
      const RecordedTopic& topic = recording_->topics()[message.topic];
      found = known.emplace(message.topic, MessageDecoder<M>(topic.format, topic.definition)).first;
    }
    found->second.decode(message.bytes, value);
  }

  template <typename M>
  [[nodiscard]] M decode(const RecordedMessage& message) {
    M value;
    decode(message, value);
    return value;
  }

 private:
  template <typename M>
  using Decoders = std::map<std::size_t, MessageDecoder<M>>;

  const Recording* recording_;
  std::tuple<Decoders<msg::LaserScan>, Decoders<msg::MultiEchoLaserScan>,
             Decoders<msg::PointCloud2>, Decoders<msg::Odometry>, Decoders<msg::Imu>,
             Decoders<msg::TFMessage>, Decoders<msg::WheelTicks>, Decoders<msg::PoseStamped>,
             Decoders<msg::PoseWithCovarianceStamped>, Decoders<msg::Image>,
             Decoders<msg::CompressedImage>, Decoders<msg::CameraInfo>>
      decoders_{};
};

}  // namespace loopstone
