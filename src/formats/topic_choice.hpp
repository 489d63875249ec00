#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "formats/camera_choice.hpp"
#include "formats/topic_survey.hpp"
#include "loopstone/formats/topic_options.hpp"
#include "loopstone/geometry/pose3.hpp"

namespace loopstone {

/// A topic that is used as a laser.
struct ChosenLaser {
  std::size_t topic = 0;  ///< in TopicSurvey::topics
  /// By tf, as it was told last; nothing when tf does not tell.
  std::optional<Pose3> base_T_laser{};
};

/// Where the robot's own poses come from: a topic, or a frame of tf.
struct ChosenOdometry {
  std::optional<std::size_t> topic{};
  std::string parent{};  ///< of tf: "odom"
  std::string child{};   ///< the frame whose poses they are
};

/// Which topics of a recording are used, and for what.
struct TopicChoice {
  std::string base_frame{};  ///< empty when nothing names one
  std::vector<ChosenLaser> lasers{};
  std::optional<ChosenOdometry> odometry{};
  std::optional<std::size_t> imu{};
  std::optional<std::size_t> wheels{};
  std::optional<ChosenCamera> camera{};

  std::vector<TopicRole> roles{};       ///< of each topic of the survey
  std::vector<std::string> remarks{};   ///< of each: why it is not used
  std::vector<std::string> choices{};   ///< in plain words, one a role
  std::vector<std::string> warnings{};  ///< what had to be guessed
};

/// Lasers that look more than this out of the horizontal are named.
inline constexpr double kTiltWorthAWordDeg = 2.0;
/// Beyond this they are no use for a map of the plane.
inline constexpr double kMostTiltDeg = 15.0;

/// How far a laser's plane is from the horizontal [rad]; upside down is 0, too.
[[nodiscard]] double tilt_of(const Pose3& base_T_laser);
[[nodiscard]] bool is_upside_down(const Pose3& base_T_laser);

/// Throws UsageError when a topic that the user named is not there or can't be what it is to be.
[[nodiscard]] TopicChoice choose_topics(const TopicSurvey& survey, const TopicOptions& options);

}  // namespace loopstone
