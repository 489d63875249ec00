#pragma once

#include <memory>
#include <string>
#include <vector>

#include "formats/topic_writer.hpp"
#include "loopstone/formats/rgbd_files.hpp"
#include "loopstone/messages/message_types.hpp"
#include "loopstone/sensor/robot_model.hpp"

namespace loopstone {

/// Writes RGB-D frames as drivers of cameras do: /camera/color/image_raw/compressed (PNG) and
/// /camera/depth/image_raw (16UC1, millimetres), each with its camera_info, in optical frames.
class PictureTopics {
 public:
  explicit PictureTopics(const RobotModel& robot) : camera_(robot.camera), loader_(camera_) {}

  /// Of frames that are messages of another recording.
  void use_pictures(std::shared_ptr<const PictureStore> pictures);
  /// Throws DataError when a picture can't be read.
  void write(const RgbdFrame& frame, TopicWriter& writer);

  /// Where the camera sits; of one that moves, where it sat when this frame was taken.
  /// \param stamp  of the message
  [[nodiscard]] std::vector<msg::TransformStamped> mounts(Stamp stamp,
                                                          const RgbdFrame& frame) const;

 private:
  void write_colour(const RgbdFrame& frame, TopicWriter& writer);
  void write_depth(const RgbdFrame& frame, TopicWriter& writer);
  /// PNG; the file's own bytes when that is what it holds.
  [[nodiscard]] std::string colour_png(const RgbdFrame& frame) const;

  CameraModel camera_;
  std::shared_ptr<const PictureStore> pictures_{};
  RgbdLoader loader_;
};

}  // namespace loopstone
