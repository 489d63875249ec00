#include "formats/stream_look.hpp"

#include <utility>

#include "formats/topic_survey.hpp"

namespace loopstone {

void StreamLook::take(const RecordedMessage& message, const RecordedTopics& topics) {
  if (!first_) first_ = Clock::now();
  has_laser_ = has_laser_ || is_laser(kind_of(topics.all()[message.topic].type));
  if (!is_on_) return;
  kept_.push_back({message.topic,
                   message.recorded,
                   message.offset,
                   {message.bytes.begin(), message.bytes.end()}});
}

std::optional<RecordedMessage> StreamLook::next_kept(const RecordedTopics& topics) {
  while (at_kept_ < kept_.size()) {
    const Kept* kept = &kept_[at_kept_];
    if (is_on_) {
      ++at_kept_;
    } else {
      in_use_ = std::move(kept_.front());
      kept_.pop_front();
      kept = &in_use_;
    }
    if (!topics.is_wanted(kept->topic)) continue;
    return RecordedMessage{.topic = kept->topic,
                           .recorded = kept->recorded,
                           .bytes = kept->bytes,
                           .file = &name_,
                           .offset = kept->offset};
  }
  return {};
}

std::optional<StreamLook::Clock::time_point> StreamLook::until() const {
  if (!is_on_ || !look_s_ || !has_laser_) return {};
  return *first_ +
         std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(*look_s_));
}

}  // namespace loopstone
