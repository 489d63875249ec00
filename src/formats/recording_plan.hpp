#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "formats/recording.hpp"
#include "formats/topic_choice.hpp"
#include "formats/topic_clock.hpp"
#include "formats/topic_survey.hpp"
#include "formats/wheel_plan.hpp"
#include "loopstone/formats/log_reader.hpp"

namespace loopstone {

/// What was understood of a recording before its messages are read: which topics, by which clocks.
struct RecordingPlan {
  TopicSurvey survey{};
  TopicChoice choice{};
  WheelPlan wheels{};  ///< by other messages than our own
  ClockChoice clocks{};
  std::vector<TopicClock> clock_of{};  ///< of each topic of the survey
  TopicClock tf_clock{};               ///< of the frames that move
};

/// Looks at the beginning of a recording, which is at its beginning again afterwards. Throws what
/// the recording throws, and UsageError for topics that the user named and that can't be used.
[[nodiscard]] RecordingPlan plan_recording(Recording& recording, const LogOptions& options);

/// What of the options is the container's.
[[nodiscard]] RecordingOptions recording_options(const LogOptions& options,
                                                 std::function<void(const Problem&)> on_damage);

}  // namespace loopstone
