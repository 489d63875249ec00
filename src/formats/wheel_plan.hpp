#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "formats/recording.hpp"
#include "formats/topic_choice.hpp"
#include "formats/topic_survey.hpp"
#include "formats/wheel_fields.hpp"
#include "loopstone/formats/topic_options.hpp"
#include "loopstone/sensor/robot_model.hpp"

// Wheels by other messages than our own: joints, and counts by their definition.

namespace loopstone {

/// What of a recording tells of one wheel.
struct PlannedWheel {
  std::size_t topic = 0;  ///< in TopicSurvey::topics
  std::string name{};     ///< of the joint; else empty
  WheelField field{};     ///< of the message; of joints only the unit
  WheelSpot spot{};
};

/// The wheels that are used; none where odometry is told, or what is needed is not known.
struct WheelPlan {
  std::vector<PlannedWheel> wheels{};
  /// By which the counts that are made of them are to be read.
  WheelModel model{};
  bool counts_are_cumulative = true;  ///< of the messages

  [[nodiscard]] bool empty() const { return wheels.empty(); }
  /// Each once.
  [[nodiscard]] std::vector<std::size_t> topics() const;
};

/// Angles are counted in this many radians [rad].
inline constexpr double kRadiansPerCount = 1e-4;

/// Decides by the names of joints and fields, by what the user says of the wheels and by tf. Where
/// there may be wheels and no odometry, or the user names them, the beginning of their topics is
/// read: what it tells is entered in `survey`, roles, remarks, words and warnings in `choice`. Then
/// the recording is at its beginning again. Odometry gives way to wheels that are named when it is
/// not named itself.
/// Throws UsageError when topics that the user named tell no wheels of both sides, and what the
/// recording throws.
[[nodiscard]] WheelPlan plan_wheels(Recording& recording, const TopicOptions& options,
                                    TopicSurvey& survey, TopicChoice& choice);

/// The wheels are not used after all.
void drop_wheels(const std::string& why, const TopicSurvey& survey, WheelPlan& plan,
                 TopicChoice& choice);

}  // namespace loopstone
