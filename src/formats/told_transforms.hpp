#pragma once

#include <optional>
#include <string>

#include "formats/frame_tree.hpp"
#include "formats/recording.hpp"
#include "formats/ros_geometry.hpp"
#include "loopstone/messages/message_types.hpp"

namespace loopstone {

/// Whether a topic of tf tells what never moves.
[[nodiscard]] inline bool is_static_tf(const RecordedTopic& topic) {
  return topic.name.ends_with("tf_static");
}

/// One transform of a message of tf, as FrameTree takes it.
struct ToldTransform {
  std::string parent{};
  std::string child{};
  Stamp stamp{};                          ///< the message's own
  std::optional<Pose3> parent_T_child{};  ///< nothing: the pose is no pose
};

/// take(ToldTransform) for each of a message.
template <typename Take>
void for_each_transform(const msg::TFMessage& message, Take&& take) {
  for (const msg::TransformStamped& told : message.transforms) {
    take(ToldTransform{frame_name(told.header.frame_id), frame_name(told.child_frame_id),
                       told.header.stamp, to_pose3(told.transform)});
  }
}

}  // namespace loopstone
