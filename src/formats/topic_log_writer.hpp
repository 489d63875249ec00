#pragma once

#include <memory>

#include "formats/recording_writer.hpp"
#include "loopstone/formats/log_format.hpp"
#include "loopstone/formats/log_reader.hpp"

namespace loopstone {

/// A log as the recording that a robot with ROS would have made: /scan (a second laser: /scan_2),
/// /odom with tf of odom to base_link, /imu/data, /wheel_ticks, the camera's pictures
/// (PictureTopics), and the mounts of lasers and camera as /tf_static.
[[nodiscard]] std::unique_ptr<LogWriter> create_topic_log(const LogTarget& target,
                                                          std::unique_ptr<RecordingWriter> writer,
                                                          const RobotModel& robot);

}  // namespace loopstone
