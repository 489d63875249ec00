#include "formats/topic_survey.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "formats/ros_geometry.hpp"
#include "formats/told_transforms.hpp"
#include "formats/topic_decoders.hpp"
#include "formats/wheel_fields.hpp"
#include "loopstone/messages/message_codec.hpp"

namespace loopstone {
namespace {

/// What is enough to know a topic by.
constexpr std::int64_t kEnough = 100;
/// How much of the recording is looked at: by its own clock, and by its bytes. Until a laser was
/// seen the bytes alone count.
constexpr double kMostSeconds = 30.0;
/// Drivers begin within so many seconds of one another.
constexpr double kSureSeconds = 10.0;
constexpr std::int64_t kMostBytes = std::int64_t{1} << 28;
constexpr std::size_t kMostMoving = 1000;

struct KindOfType {
  std::string_view type;
  TopicKind kind;
};
constexpr std::array<KindOfType, 13> kKinds{{
    {"sensor_msgs/LaserScan", TopicKind::kScan},
    {"sensor_msgs/MultiEchoLaserScan", TopicKind::kEchoScan},
    {"sensor_msgs/PointCloud2", TopicKind::kCloud},
    {"nav_msgs/Odometry", TopicKind::kOdometry},
    {"sensor_msgs/Imu", TopicKind::kImu},
    {"sensor_msgs/JointState", TopicKind::kJoints},
    {"loopstone_msgs/WheelTicks", TopicKind::kTicks},
    {"tf2_msgs/TFMessage", TopicKind::kTransforms},
    {"geometry_msgs/PoseStamped", TopicKind::kPose},
    {"geometry_msgs/PoseWithCovarianceStamped", TopicKind::kPoseWithCovariance},
    {"sensor_msgs/Image", TopicKind::kPicture},
    {"sensor_msgs/CompressedImage", TopicKind::kPackedPicture},
    {"sensor_msgs/CameraInfo", TopicKind::kCameraInfo},
}};

/// Pictures take most of a recording's bytes, so they have a look of their own: so many of each
/// topic, and so much of the file.
constexpr std::int64_t kEnoughPictures = 20;
constexpr std::int64_t kMostPictureBytes = std::int64_t{1} << 27;

bool is_of_camera(TopicKind kind) {
  return kind == TopicKind::kPicture || kind == TopicKind::kPackedPicture ||
         kind == TopicKind::kCameraInfo;
}

/// Topics whose first messages tell how to use them.
bool is_looked_at(TopicKind kind) {
  return kind != TopicKind::kOther && kind != TopicKind::kJoints && kind != TopicKind::kCounts &&
         !is_of_camera(kind);
}

/// Reads messages of all topics into the survey.
class Surveyor {
 public:
  explicit Surveyor(Recording& recording) : recording_(recording), decoders_(recording) {}

  TopicSurvey run(bool with_pictures) {
    recording_.want([](const RecordedTopic& topic) { return is_looked_at(kind_of(topic.type)); });
    look_at_the_beginning();
    if (!survey_.is_whole && recording_.is_indexed()) {
      look_for_late_topics();
      look_for_fixed_frames();
    }
    if (with_pictures) look_at_cameras();
    note_topics();
    recording_.want({});
    recording_.rewind();
    return std::move(survey_);
  }

 private:
  void look_at_the_beginning() {
    std::int64_t bytes = 0;
    std::optional<Stamp> first;
    while (const auto message = recording_.next()) {
      take(*message);
      bytes += static_cast<std::int64_t>(message->bytes.size());
      if (!first) first = message->recorded;
      const double passed_s = message->recorded.seconds() - first->seconds();
      const bool is_late = passed_s > kMostSeconds && has_seen_laser_;
      if (bytes > kMostBytes || is_late || is_enough(passed_s)) return;
    }
    survey_.is_whole = true;
  }

  /// Topics that begin late: an index tells of them, and leads there.
  void look_for_late_topics() {
    note_topics();
    const auto is_late = [this](const RecordedTopic& topic) {
      const TopicFacts* const facts = survey_.find(topic.name);
      return facts != nullptr && is_looked_at(facts->kind) && facts->type == topic.type &&
             facts->seen == 0 && facts->messages.value_or(0) > 0;
    };
    if (std::ranges::none_of(recording_.topics(), is_late)) return;
    std::set<std::string> late;
    for (const RecordedTopic& topic : recording_.topics()) {
      if (is_late(topic)) late.insert(topic.name);
    }
    recording_.rewind();
    recording_.want([&](const RecordedTopic& topic) { return late.contains(topic.name); });
    std::int64_t bytes = 0;
    while (const auto message = recording_.next()) {
      take(*message);
      bytes += static_cast<std::int64_t>(message->bytes.size());
      const auto is_known = [&](const TopicFacts& facts) {
        return !late.contains(facts.name) || facts.seen >= kEnough ||
               facts.seen >= facts.messages.value_or(0);
      };
      if (bytes > kMostBytes || std::ranges::all_of(survey_.topics, is_known)) return;
    }
  }

  void look_for_fixed_frames() {
    recording_.rewind();
    const auto is_static = [](const RecordedTopic& topic) {
      return kind_of(topic.type) == TopicKind::kTransforms && is_static_tf(topic);
    };
    if (std::ranges::none_of(recording_.topics(), is_static)) return;
    recording_.want(is_static);
    while (const auto message = recording_.next()) take(*message);
  }

  void look_at_cameras() {
    note_topics();
    const auto is_it = [](const RecordedTopic& topic) { return is_of_camera(kind_of(topic.type)); };
    if (std::ranges::none_of(recording_.topics(), is_it)) return;
    recording_.rewind();
    recording_.want(is_it);
    while (const auto message = recording_.next()) {
      take(*message);
      if (recording_.progress().bytes_done > kMostPictureBytes || knows_cameras()) return;
    }
  }

  [[nodiscard]] bool knows_cameras() const {
    return std::ranges::all_of(survey_.topics, [](const TopicFacts& topic) {
      const std::int64_t enough = topic.kind == TopicKind::kCameraInfo ? 1 : kEnoughPictures;
      return !is_of_camera(topic.kind) ||
             topic.seen >= std::min(enough, topic.messages.value_or(enough));
    });
  }

  /// Every topic has an entry, also those of which nothing was read.
  void note_topics() {
    for (std::size_t i = 0; i < recording_.topics().size(); ++i) (void)facts_of(i);
  }

  bool is_enough(double passed_s) {
    if (passed_s < 1.0) return false;
    // Without an index nothing tells of topics that are yet to come.
    if (!recording_.is_indexed() && (!has_seen_laser_ || passed_s < kSureSeconds)) return false;
    note_topics();
    return std::ranges::all_of(survey_.topics, [&](const TopicFacts& topic) {
      if (!is_looked_at(topic.kind) || topic.seen >= kEnough) return true;
      return topic.messages && topic.seen >= *topic.messages;
    });
  }

  TopicFacts& facts_of(std::size_t recorded) {
    if (recorded < place_.size()) return survey_.topics[place_[recorded]];
    while (place_.size() <= recorded) place_.push_back(enter(place_.size()));
    return survey_.topics[place_[recorded]];
  }

  /// The place of a recorded topic among the facts.
  std::size_t enter(std::size_t recorded) {
    const RecordedTopic& topic = recording_.topics()[recorded];
    auto& topics = survey_.topics;
    const std::size_t place = survey_.find(topic).value_or(topics.size());
    if (place == topics.size()) {
      topics.push_back({.name = topic.name, .type = topic.type, .kind = kind_of(topic)});
      topics.back().fault = topic.unreadable;
    }
    TopicFacts& facts = topics[place];
    facts.recorded.push_back(recorded);
    if (topic.messages) facts.messages = facts.messages.value_or(0) + *topic.messages;
    return place;
  }

  void take(const RecordedMessage& message) {
    TopicFacts& facts = facts_of(message.topic);
    const RecordedTopic& topic = recording_.topics()[message.topic];
    if (!topic.unreadable.empty()) return;
    ++facts.seen;
    if (facts.is_laser()) has_seen_laser_ = true;
    try {
      if (facts.kind == TopicKind::kTransforms) {
        take_transforms(topic, message);
      } else if (is_looked_at(facts.kind) || is_of_camera(facts.kind)) {
        look_at(facts, topic, message);
      }
      facts.is_decoded = true;
      facts.fault.clear();
    } catch (const MessageError& error) {
      if (!facts.is_decoded) facts.fault = error.what();
    }
  }

  void look_at(TopicFacts& facts, const RecordedTopic& topic, const RecordedMessage& message) {
    const auto header = decode_header(topic.format, message.bytes);
    facts.stamps.add(header ? std::optional(header->stamp) : std::nullopt, message.recorded);
    if (header && facts.frame.empty()) facts.frame = frame_name(header->frame_id);
    if (facts.kind == TopicKind::kImu) {
      decoders_.decode(message, imu_message_);
      if (imu_message_.angular_velocity_covariance[0] == -1.0) {
        throw MessageError(0, "says of itself that it does not measure turning");
      }
      facts.force += to_eigen(imu_message_.linear_acceleration);
    }
    if (facts.is_decoded) return;
    if (facts.kind == TopicKind::kOdometry) {
      facts.child_frame = frame_name(decoders_.decode<msg::Odometry>(message).child_frame_id);
    }
    if (facts.kind == TopicKind::kScan) {
      facts.beams = decoders_.decode<msg::LaserScan>(message).ranges.size();
    }
    if (is_of_camera(facts.kind)) look_at_camera(facts, message);
  }

  void look_at_camera(TopicFacts& facts, const RecordedMessage& message) {
    if (facts.kind == TopicKind::kCameraInfo) {
      facts.camera = decoders_.decode<msg::CameraInfo>(message);
    } else if (facts.kind == TopicKind::kPicture) {
      const auto picture = decoders_.decode<msg::Image>(message);
      facts.picture = {picture.encoding, static_cast<int>(std::min(picture.width, 1U << 16U)),
                       static_cast<int>(std::min(picture.height, 1U << 16U))};
    } else {
      facts.picture.encoding = decoders_.decode<msg::CompressedImage>(message).format;
    }
  }

  void take_transforms(const RecordedTopic& topic, const RecordedMessage& message) {
    decoders_.decode(message, transforms_message_);
    for_each_transform(transforms_message_, [&](const ToldTransform& told) {
      if (!told.parent_T_child) return;
      if (is_static_tf(topic)) {
        survey_.frames.add_fixed(told.parent, told.child, *told.parent_T_child);
        return;
      }
      survey_.frames.add(told.parent, told.child, told.stamp, *told.parent_T_child);
      if (MovingFrame* moving = moving_frame(told.parent, told.child)) {
        moving->stamps.add(told.stamp, message.recorded);
      }
    });
  }

  MovingFrame* moving_frame(const std::string& parent, const std::string& child) {
    for (MovingFrame& moving : survey_.moving) {
      if (moving.child == child && moving.parent == parent) return &moving;
    }
    if (survey_.moving.size() >= kMostMoving) return nullptr;
    survey_.moving.push_back({.parent = parent, .child = child});
    return &survey_.moving.back();
  }

  Recording& recording_;
  TopicSurvey survey_{};
  std::vector<std::size_t> place_{};  ///< in survey_.topics, by the number in the recording
  TopicDecoders decoders_;
  bool has_seen_laser_ = false;
  msg::Imu imu_message_{};
  msg::TFMessage transforms_message_{};
};

}  // namespace

TopicKind kind_of(const std::string& type) {
  const auto* const known =
      std::ranges::find_if(kKinds, [&](const KindOfType& kind) { return kind.type == type; });
  return known == kKinds.end() ? TopicKind::kOther : known->kind;
}

TopicKind kind_of(const RecordedTopic& topic) {
  const TopicKind kind = kind_of(topic.type);
  if (kind != TopicKind::kOther || wheel_fields(topic).fields.empty()) return kind;
  return TopicKind::kCounts;
}

double TopicFacts::rate_hz() const {
  const double period_s = stamps.period_s();
  return period_s > 0.0 ? 1.0 / period_s : 0.0;
}

const TopicFacts* TopicSurvey::find(std::string_view name) const {
  const auto found =
      std::ranges::find_if(topics, [&](const TopicFacts& topic) { return topic.name == name; });
  return found == topics.end() ? nullptr : &*found;
}

std::optional<std::size_t> TopicSurvey::find(const RecordedTopic& topic) const {
  const auto found = std::ranges::find_if(topics, [&](const TopicFacts& known) {
    return known.name == topic.name && known.type == topic.type;
  });
  if (found == topics.end()) return std::nullopt;
  return static_cast<std::size_t>(found - topics.begin());
}

TopicSurvey survey_topics(Recording& recording, bool with_pictures) {
  return Surveyor(recording).run(with_pictures);
}

}  // namespace loopstone
