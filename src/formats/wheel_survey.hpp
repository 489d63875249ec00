#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "formats/recording.hpp"
#include "formats/topic_survey.hpp"
#include "formats/wheel_plan.hpp"

namespace loopstone {

/// Wheels of both sides of one robot, all told in the same unit.
struct WheelCandidate {
  std::vector<PlannedWheel> wheels{};
  bool has_moved = false;  ///< within what was looked at

  [[nodiscard]] WheelUnit unit() const;
  /// Counts whose messages say how many make a turn are as good as angles.
  [[nodiscard]] bool tells_angles() const;
  [[nodiscard]] std::vector<std::string> names(const TopicSurvey& survey) const;
};

/// Looks at the first messages of topics, and enters their stamps, frames and faults in the survey.
/// The recording is at its beginning again afterwards.
/// \param topics  in the survey: joints, and counts by their definition
/// \returns       the best first
[[nodiscard]] std::vector<WheelCandidate> survey_wheels(Recording& recording, TopicSurvey& survey,
                                                        const std::vector<std::size_t>& topics);

}  // namespace loopstone
