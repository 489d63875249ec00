#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/frame_tree.hpp"
#include "formats/recording.hpp"
#include "formats/topic_clock.hpp"
#include "loopstone/formats/topic_options.hpp"
#include "loopstone/messages/message_types.hpp"

namespace loopstone {

/// What kind of messages a topic holds, as far as its type tells.
enum class TopicKind {
  kOther,
  kScan,        ///< sensor_msgs/LaserScan
  kEchoScan,    ///< sensor_msgs/MultiEchoLaserScan
  kCloud,       ///< sensor_msgs/PointCloud2
  kOdometry,    ///< nav_msgs/Odometry
  kImu,         ///< sensor_msgs/Imu
  kJoints,      ///< sensor_msgs/JointState
  kTicks,       ///< loopstone_msgs/WheelTicks
  kCounts,      ///< wheels by the fields of another type
  kTransforms,  ///< tf2_msgs/TFMessage
  kPose,        ///< geometry_msgs/PoseStamped
  kPoseWithCovariance,
  kPicture,        ///< sensor_msgs/Image
  kPackedPicture,  ///< sensor_msgs/CompressedImage
  kCameraInfo,     ///< sensor_msgs/CameraInfo
};

[[nodiscard]] constexpr bool is_laser(TopicKind kind) {
  return kind == TopicKind::kScan || kind == TopicKind::kEchoScan || kind == TopicKind::kCloud;
}

[[nodiscard]] TopicKind kind_of(const std::string& type);
/// Also by what the topic's definition tells.
[[nodiscard]] TopicKind kind_of(const RecordedTopic& topic);

/// Of the first picture of a topic.
struct PictureFacts {
  std::string encoding{};  ///< of a packed one, its format
  int width_px = 0;        ///< 0: not known before it is unpacked
  int height_px = 0;
};

/// What the beginning of a recording tells of a topic; topics of one name and type are one.
struct TopicFacts {
  std::string name{};
  std::string type{};
  TopicKind kind = TopicKind::kOther;
  std::vector<std::size_t> recorded{};     ///< in Recording::topics()
  std::int64_t seen = 0;                   ///< in the survey
  std::optional<std::int64_t> messages{};  ///< in the whole recording, by its index
  std::string frame{};                     ///< of the first header
  std::string child_frame{};               ///< of odometry
  StampFacts stamps{};
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< of an imu: sum of its accelerations
  std::size_t beams = 0;                            ///< of the first scan
  PictureFacts picture{};
  std::optional<msg::CameraInfo> camera{};  ///< the first one
  bool is_decoded = false;                  ///< one of its messages could be read
  std::string fault{};                      ///< why its messages can't be read

  [[nodiscard]] bool is_laser() const { return loopstone::is_laser(kind); }
  [[nodiscard]] bool is_picture() const {
    return kind == TopicKind::kPicture || kind == TopicKind::kPackedPicture;
  }
  [[nodiscard]] bool has_messages() const { return seen > 0 || messages.value_or(0) > 0; }
  [[nodiscard]] double rate_hz() const;
};

/// The stamps of a frame that tf moves.
struct MovingFrame {
  std::string parent{};
  std::string child{};
  StampFacts stamps{};
};

struct TopicSurvey {
  std::vector<TopicFacts> topics{};
  FrameTree frames{};
  std::vector<MovingFrame> moving{};
  bool is_whole = false;  ///< the recording ended within the survey

  [[nodiscard]] const TopicFacts* find(std::string_view name) const;
  /// In topics, the one of this name and type.
  [[nodiscard]] std::optional<std::size_t> find(const RecordedTopic& topic) const;
};

/// Reads the beginning of a recording: some seconds, until every topic that may be of use was seen
/// often enough, or there is no more to expect; what stands fixed (tf_static) from the whole
/// recording, when an index leads there. The recording is at its beginning again afterwards.
/// \param with_pictures  topics of pictures are looked at, too, which takes longer
/// Throws what the recording throws.
[[nodiscard]] TopicSurvey survey_topics(Recording& recording, bool with_pictures);

}  // namespace loopstone
