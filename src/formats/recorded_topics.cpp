#include "formats/recorded_topics.hpp"

#include <string_view>
#include <utility>

namespace loopstone {
namespace {

std::size_t hash_of(const RecordedTopic& topic) {
  const std::hash<std::string_view> hash;
  constexpr std::size_t kOdd = 0x9e3779b97f4a7c15U;
  return (hash(topic.name) * kOdd + hash(topic.type)) * kOdd + hash(topic.definition.text);
}

bool is_equal(const RecordedTopic& a, const RecordedTopic& b) {
  return a.name == b.name && a.type == b.type && a.format == b.format && a.hash == b.hash &&
         a.unreadable == b.unreadable && a.definition.language == b.definition.language &&
         a.definition.text == b.definition.text;
}

}  // namespace

RecordedTopics::RecordedTopics(const MemoryBudget& memory, std::uint64_t file_bytes,
                               std::string file)
    : memory_(memory), file_bytes_(file_bytes), file_(std::move(file)) {}

std::size_t RecordedTopics::add(RecordedTopic topic) {
  const std::size_t hash = hash_of(topic);
  const auto [first, last] = by_hash_.equal_range(hash);
  for (auto i = first; i != last; ++i) {
    if (is_equal(topics_[i->second], topic)) return i->second;
  }
  hold(sizeof topic + topic.name.size() + topic.type.size() + topic.definition.text.size() +
       topic.hash.size() + topic.unreadable.size());
  by_hash_.emplace(hash, topics_.size());
  topics_.push_back(std::move(topic));
  wanted_.push_back(static_cast<char>(!want_ || want_(topics_.back())));
  return topics_.size() - 1;
}

void RecordedTopics::hold(std::uint64_t bytes) {
  held_bytes_ += bytes;
  memory_.require(held_bytes_, file_bytes_, Growth::kNumbers, {file_});
}

void RecordedTopics::count(std::size_t topic, std::int64_t messages) {
  topics_[topic].messages = topics_[topic].messages.value_or(0) + messages;
}

void RecordedTopics::want(std::function<bool(const RecordedTopic&)> wanted) {
  want_ = std::move(wanted);
  for (std::size_t i = 0; i < topics_.size(); ++i) {
    wanted_[i] = static_cast<char>(!want_ || want_(topics_[i]));
  }
}

}  // namespace loopstone
