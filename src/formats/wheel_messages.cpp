#include "formats/wheel_messages.hpp"

#include <utility>

#include "formats/frame_tree.hpp"

namespace loopstone {

const WheelMessage& WheelMessages::decode(const RecordedMessage& message, std::size_t topic) {
  told_ = {};
  const TopicFacts& facts = survey_->topics[topic];
  if (facts.kind == TopicKind::kJoints) {
    decode_joints(message);
  } else {
    decode_fields(message, facts.name);
  }
  return told_;
}

void WheelMessages::decode_joints(const RecordedMessage& message) {
  auto known = joint_decoders_.find(message.topic);
  if (known == joint_decoders_.end()) {
    const RecordedTopic& topic = recording_->topics()[message.topic];
    known =
        joint_decoders_
            .emplace(message.topic, MessageDecoder<msg::JointState>(topic.format, topic.definition))
            .first;
  }
  known->second.decode(message.bytes, joints_);
  told_.stamp = joints_.header.stamp;
  told_.frame = frame_name(joints_.header.frame_id);
  for (std::size_t i = 0; i < joints_.name.size(); ++i) {
    ToldWheel wheel{.name = joints_.name[i], .field = {.unit = WheelUnit::kRadians}};
    wheel.spot = wheel_spot(wheel.name);
    if (!wheel.spot && !is_steering(wheel.name)) continue;
    if (i < joints_.position.size()) wheel.position = joints_.position[i];
    if (i < joints_.velocity.size()) wheel.speed = joints_.velocity[i];
    told_.wheels.push_back(std::move(wheel));
  }
}

void WheelMessages::decode_fields(const RecordedMessage& message, const std::string& topic) {
  auto known = decoders_.find(message.topic);
  if (known == decoders_.end()) {
    const RecordedTopic& recorded = recording_->topics()[message.topic];
    WheelFields fields = wheel_fields(recorded);
    known = decoders_
                .emplace(message.topic,
                         ByDefinition{AnyMessageDecoder(recorded.format, fields.definition),
                                      std::move(fields.fields)})
                .first;
  }
  const auto values = known->second.decoder.decode(message.bytes);
  for (const char* const path : {"header.stamp", "stamp"}) {
    const auto stamp = values.stamps.find(path);
    if (stamp != values.stamps.end() && !told_.stamp) told_.stamp = stamp->second;
  }
  const auto frame = values.strings.find("header.frame_id");
  if (frame != values.strings.end()) told_.frame = frame_name(frame->second);
  for (const WheelField& field : known->second.fields) {
    const auto value = values.numbers.find(field.path);
    if (value == values.numbers.end()) continue;
    ToldWheel wheel{.field = field, .spot = field.spot};
    if (!wheel.spot) wheel.spot = spot_of(words_of_name(topic));
    if (field.unit == WheelUnit::kRadiansPerSecond) {
      wheel.speed = value->second;
    } else {
      wheel.position = value->second;
    }
    if (!field.resolution.empty()) {
      const auto counts = values.numbers.find(field.resolution);
      if (counts == values.numbers.end() || !(counts->second >= 1.0)) {
        throw MessageError(0, "the encoder has no counts a turn");
      }
      wheel.counts_a_turn = counts->second;
    }
    told_.wheels.push_back(std::move(wheel));
  }
}

}  // namespace loopstone
