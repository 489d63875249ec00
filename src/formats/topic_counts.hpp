#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "formats/recording.hpp"
#include "formats/topic_choice.hpp"
#include "formats/topic_survey.hpp"
#include "loopstone/formats/topic_options.hpp"

namespace loopstone {

/// Counts the messages of a recording's topics as they go by.
class TopicCounts {
 public:
  void add(const RecordedMessage& message);

  /// One entry a topic of the recording, in its order; of topics that were not read what the index
  /// says.
  [[nodiscard]] std::vector<TopicSummary> summaries(const Recording& recording,
                                                    const TopicSurvey& survey,
                                                    const TopicChoice& choice) const;

 private:
  struct Count {
    std::int64_t messages = 0;
    Stamp first{};
    Stamp last{};
    double largest_gap_s = 0.0;
  };
  [[nodiscard]] Count sum_of(const Recording& recording, const TopicFacts& facts) const;

  std::vector<Count> counts_{};  ///< of the recorded topics
  std::optional<Stamp> first_{};
  Stamp last_{};
};

}  // namespace loopstone
