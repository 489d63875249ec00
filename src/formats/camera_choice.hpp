#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "formats/topic_survey.hpp"
#include "loopstone/sensor/camera_model.hpp"

namespace loopstone {

/// Two topics that are used as a camera of depth and colour.
struct ChosenCamera {
  std::size_t depth = 0;  ///< in TopicSurvey::topics
  std::size_t colour = 0;
  CameraModel model{};         ///< as the recording tells; as good as nothing where `fault` speaks
  bool mount_moves = false;    ///< the camera's place on the robot is another at each picture
  std::string frame{};         ///< of the depth pictures, in tf
  bool frame_is_body = false;  ///< its x looks ahead, not its z
  double base_height_m = 0.0;  ///< of the robot's frame above base_footprint, where tf has one
  std::string fault{};         ///< what the recording does not tell of it; empty when it is enough
  std::vector<std::string> notes{};
};

/// Whether the pictures of a topic show depth, by encoding and name.
[[nodiscard]] bool shows_depth(const TopicFacts& topic);
/// Whether they show colour, or grey.
[[nodiscard]] bool shows_colour(const TopicFacts& topic);

/// The two of the candidates that belong together: of one camera by their names, with lenses and a
/// mount that the recording tells. Nothing when either list is empty.
/// \param base_frame  the robot's, in tf
[[nodiscard]] std::optional<ChosenCamera> choose_camera(const TopicSurvey& survey,
                                                        const std::string& base_frame,
                                                        const std::vector<std::size_t>& depths,
                                                        const std::vector<std::size_t>& colours);

/// The body-like frame (x ahead, y left, z up) of a camera whose frame in tf is optical (z ahead),
/// as REP-103 wants it, or is body-like itself; above the floor.
[[nodiscard]] Pose3 robot_T_camera(const ChosenCamera& camera, const Pose3& base_T_frame);

}  // namespace loopstone
