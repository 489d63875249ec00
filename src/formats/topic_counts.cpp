#include "formats/topic_counts.hpp"

#include <algorithm>

namespace loopstone {

void TopicCounts::add(const RecordedMessage& message) {
  if (message.topic >= counts_.size()) counts_.resize(message.topic + 1);
  Count& count = counts_[message.topic];
  if (count.messages == 0) {
    count.first = message.recorded;
  } else {
    const double gap_s = message.recorded.seconds() - count.last.seconds();
    count.largest_gap_s = std::max(count.largest_gap_s, gap_s);
  }
  ++count.messages;
  count.last = message.recorded;
  if (!first_) first_ = message.recorded;
  last_ = message.recorded;
}

/// Of all publishers of one topic together.
TopicCounts::Count TopicCounts::sum_of(const Recording& recording, const TopicFacts& facts) const {
  Count sum;
  for (std::size_t recorded = 0; recorded < counts_.size(); ++recorded) {
    const Count& count = counts_[recorded];
    const RecordedTopic& topic = recording.topics()[recorded];
    if (count.messages == 0 || topic.name != facts.name || topic.type != facts.type) continue;
    sum.first = sum.messages == 0 ? count.first : std::min(sum.first, count.first);
    sum.last = sum.messages == 0 ? count.last : std::max(sum.last, count.last);
    sum.messages += count.messages;
    sum.largest_gap_s = std::max(sum.largest_gap_s, count.largest_gap_s);
  }
  return sum;
}

std::vector<TopicSummary> TopicCounts::summaries(const Recording& recording,
                                                 const TopicSurvey& survey,
                                                 const TopicChoice& choice) const {
  std::vector<TopicSummary> summaries;
  const auto rate_hz = [](const Count& count) {
    const double span_s = count.last.seconds() - count.first.seconds();
    const auto steps = static_cast<double>(count.messages) - 1.0;
    return steps > 0.0 && span_s > 0.0 ? steps / span_s : 0.0;
  };
  for (std::size_t i = 0; i < survey.topics.size(); ++i) {
    const TopicFacts& facts = survey.topics[i];
    Count count = sum_of(recording, facts);
    if (count.messages == 0 && first_) {
      count = {.messages = facts.messages.value_or(0), .first = *first_, .last = last_};
    }
    summaries.push_back({.name = facts.name,
                         .type = facts.type,
                         .messages = count.messages,
                         .rate_hz = rate_hz(count),
                         .largest_gap_s = count.largest_gap_s,
                         .frame = facts.frame,
                         .role = choice.roles[i],
                         .remark = choice.remarks[i]});
  }
  for (const RecordedTopic& late : recording.topics()) {
    const auto is_it = [&](const TopicSummary& known) {
      return known.name == late.name && known.type == late.type;
    };
    if (std::ranges::any_of(summaries, is_it)) continue;
    const Count count = sum_of(recording, {.name = late.name, .type = late.type});
    summaries.push_back({.name = late.name,
                         .type = late.type,
                         .messages = count.messages,
                         .rate_hz = rate_hz(count),
                         .largest_gap_s = count.largest_gap_s,
                         .remark = "begins too late in a recording without an index"});
  }
  return summaries;
}

}  // namespace loopstone
