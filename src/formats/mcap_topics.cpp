#include "formats/mcap_topics.hpp"

#include <algorithm>
#include <utility>

#include "formats/mcap_record.hpp"

namespace loopstone {
namespace {

DefinitionLanguage language_of(std::string_view encoding) {
  if (encoding == "ros1msg") return DefinitionLanguage::kRos1Msg;
  if (encoding == "ros2msg") return DefinitionLanguage::kRos2Msg;
  if (encoding == "ros2idl") return DefinitionLanguage::kRos2Idl;
  return DefinitionLanguage::kNone;
}

}  // namespace

bool McapTopics::add_schema(std::string_view fields, bool keep, RecordedTopics& topics) {
  const auto schema = read_mcap_schema(fields);
  if (!schema) return false;
  const auto known = schemas_.find(schema->id);
  if (known != schemas_.end() && keep) return true;
  Schema fresh{canonical_type(schema->name),
               {language_of(schema->encoding), std::string(schema->text)}};
  if (known == schemas_.end()) {
    topics.hold(sizeof fresh + fresh.type.size() + fresh.definition.text.size());
    schemas_.emplace(schema->id, std::move(fresh));
  } else if (known->second.type != fresh.type ||
             known->second.definition.text != fresh.definition.text ||
             known->second.definition.language != fresh.definition.language) {
    topics.hold(fresh.type.size() + fresh.definition.text.size());
    known->second = std::move(fresh);
  }
  return true;
}

bool McapTopics::add_channel(std::string_view fields, bool keep, RecordedTopics& topics) {
  const auto channel = read_mcap_channel(fields);
  if (!channel) return false;
  if (knows_channel(channel->id) && keep) return true;
  RecordedTopic topic;
  topic.name = channel->topic;
  if (channel->encoding == "ros1") topic.format = WireFormat::kRos1;
  if (channel->encoding.empty()) {
    topic.unreadable = "in an encoding that the recording does not name";
  } else if (channel->encoding != "ros1" && channel->encoding != "cdr") {
    topic.unreadable = "encoded as " + std::string(channel->encoding.substr(0, 40));
  }
  const auto schema = schemas_.find(channel->schema);
  if (channel->schema != 0 && schema != schemas_.end()) {
    topic.type = schema->second.type;
    topic.definition = schema->second.definition;
  }
  topic.hash = mcap_map_value(channel->metadata, "topic_type_hash");
  if (topic.hash.empty()) topic.hash = mcap_map_value(channel->metadata, "md5sum");
  topic_of_[channel->id] = static_cast<std::int32_t>(topics.add(std::move(topic)));
  return true;
}

std::optional<std::size_t> McapTopics::topic_of(std::uint32_t channel) const {
  const std::int32_t topic = topic_of_[channel];
  return topic == kNone ? std::nullopt : std::optional(static_cast<std::size_t>(topic));
}

std::size_t McapTopics::channels() const {
  return topic_of_.size() -
         static_cast<std::size_t>(std::count(topic_of_.begin(), topic_of_.end(), kNone));
}

}  // namespace loopstone
