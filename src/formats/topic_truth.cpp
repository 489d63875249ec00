#include <algorithm>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/frame_tree.hpp"
#include "formats/recording_plan.hpp"
#include "formats/ros_geometry.hpp"
#include "formats/told_transforms.hpp"
#include "formats/topic_decoders.hpp"
#include "formats/topic_log.hpp"
#include "loopstone/formats/log_format_words.hpp"

// True poses out of a recording.

namespace loopstone {
namespace {

/// "tf:FRAME" names a frame of tf.
constexpr std::string_view kFramePrefix = "tf:";
/// Transforms of one moment come one after the other: so long their neighbours are waited for.
constexpr Duration kPatience{1'000'000'000};

bool has_poses(const TopicFacts& facts) {
  return facts.kind == TopicKind::kOdometry || facts.kind == TopicKind::kPose ||
         facts.kind == TopicKind::kPoseWithCovariance;
}

class TruthReader {
 public:
  /// \param skip  is told what is passed; may throw
  TruthReader(Recording& recording, const LogOptions& options,
              std::function<void(const Problem&)> skip)
      : recording_(recording),
        options_(options),
        skip_(std::move(skip)),
        plan_(plan_recording(recording, options)),
        decoders_(recording),
        frames_(plan_.survey.frames.standing()) {}

  /// Of a topic with poses.
  std::vector<StampedPose2> poses_of(const TopicFacts& facts) {
    const TopicClock clock = clock_of(facts);
    recording_.want([&](const RecordedTopic& topic) {
      return topic.name == facts.name && topic.type == facts.type;
    });
    while (const auto message = recording_.next()) {
      try {
        take(facts, clock, *message);
      } catch (const MessageError& error) {
        skip_({message->where(), facts.name + ": " + error.what()});
      }
    }
    return std::move(poses_);
  }

  /// Of the robot in a frame of tf.
  std::vector<StampedPose2> poses_in(const std::string& frame) {
    recording_.want(
        [](const RecordedTopic& topic) { return kind_of(topic.type) == TopicKind::kTransforms; });
    while (const auto message = recording_.next()) {
      try {
        take_transforms(*message, frame);
      } catch (const MessageError& error) {
        skip_({message->where(), error.what()});
      }
    }
    look_up(frame, {});
    return std::move(poses_);
  }

  [[nodiscard]] const RecordingPlan& plan() const { return plan_; }

 private:
  /// The topic is brought to the clock by which the log is read.
  [[nodiscard]] TopicClock clock_of(const TopicFacts& facts) const {
    if (plan_.choice.lasers.empty()) return {};
    const TopicFacts& laser = plan_.survey.topics[plan_.choice.lasers.front().topic];
    return choose_clocks({{laser.name, &laser.stamps}, {facts.name, &facts.stamps}},
                         options_.stamps)
        .clocks.back();
  }

  void take(const TopicFacts& facts, const TopicClock& clock, const RecordedMessage& message) {
    if (facts.kind == TopicKind::kOdometry) {
      const auto told = decoders_.decode<msg::Odometry>(message);
      add(clock, told.header.stamp, told.pose.pose, frame_name(told.child_frame_id), message);
    } else if (facts.kind == TopicKind::kPose) {
      const auto told = decoders_.decode<msg::PoseStamped>(message);
      add(clock, told.header.stamp, told.pose, {}, message);
    } else {
      const auto told = decoders_.decode<msg::PoseWithCovarianceStamped>(message);
      add(clock, told.header.stamp, told.pose.pose, {}, message);
    }
  }

  void add(const TopicClock& clock, Stamp own, const msg::Pose& told, const std::string& child,
           const RecordedMessage& message) {
    const auto pose = to_pose3(told);
    if (!pose) throw MessageError(0, "the pose is no pose");
    const Pose3 of_base = frames_.pose_of(plan_.choice.base_frame, child, *pose);
    poses_.push_back({clock.time(own, message.recorded), to_pose2(of_base)});
  }

  void take_transforms(const RecordedMessage& message, const std::string& frame) {
    const auto told = decoders_.decode<msg::TFMessage>(message);
    const bool fixed = is_static_tf(recording_.topics()[message.topic]);
    for_each_transform(told, [&](const ToldTransform& transform) {
      if (!transform.parent_T_child) return;
      if (fixed) {
        frames_.add_fixed(transform.parent, transform.child, *transform.parent_T_child);
        return;
      }
      const Stamp stamp = plan_.tf_clock.time(transform.stamp, message.recorded);
      frames_.add(transform.parent, transform.child, stamp, *transform.parent_T_child);
      if (is_between(transform.child, frame)) asked_.push_back(stamp);
      look_up(frame, stamp - kPatience);
    });
  }

  /// Whether a frame lies between the robot and the one that is asked for.
  [[nodiscard]] bool is_between(const std::string& child, const std::string& frame) const {
    for (const std::string& above : frames_.ancestry(plan_.choice.base_frame)) {
      if (above == frame) return false;
      if (above == child) return true;
    }
    return false;
  }

  /// The robot's poses at the moments that were asked for, up to one.
  void look_up(const std::string& frame, std::optional<Stamp> until) {
    while (!asked_.empty() && (!until || asked_.front() <= *until)) {
      const auto pose = frames_.find(frame, plan_.choice.base_frame, asked_.front());
      if (pose) poses_.push_back({asked_.front(), to_pose2(*pose)});
      asked_.pop_front();
    }
  }

  Recording& recording_;
  const LogOptions& options_;
  std::function<void(const Problem&)> skip_;
  RecordingPlan plan_;
  TopicDecoders decoders_;
  FrameTree frames_;
  std::deque<Stamp> asked_{};
  std::vector<StampedPose2> poses_{};
};

[[noreturn]] void refuse(const std::string& name, const std::string& topic,
                         const TopicSurvey& survey) {
  std::vector<std::string> others;
  for (const TopicFacts& facts : survey.topics) {
    if (has_poses(facts)) others.push_back(facts.name);
  }
  const std::string there = others.empty() ? "no topic of the recording holds poses"
                                           : "there is " + listed(others, "and");
  throw DataError({name}, "holds no poses under the name '" + topic + "': " + there +
                              "; tf:FRAME names a frame of tf");
}

}  // namespace

Trajectory read_topic_truth(const std::string& name, const std::string& topic,
                            const OpenRecording& open, const LogOptions& options) {
  const auto tell = [&](const Problem& problem) {
    if (options.strict) throw DataError(problem.location, problem.reason);
    if (options.on_problem) options.on_problem({problem, false});
  };
  const auto recording = open(recording_options(options, tell));
  TruthReader reader(*recording, options, tell);
  const TopicSurvey& survey = reader.plan().survey;
  std::vector<StampedPose2> poses;
  if (topic.starts_with(kFramePrefix)) {
    poses = reader.poses_in(frame_name(topic.substr(kFramePrefix.size())));
  } else {
    const TopicFacts* facts = survey.find(topic);
    if (facts == nullptr) facts = survey.find("/" + topic);
    if (facts == nullptr || !has_poses(*facts)) refuse(name, topic, survey);
    poses = reader.poses_of(*facts);
  }
  if (poses.empty()) refuse(name, topic, survey);
  return Trajectory(std::move(poses));
}

}  // namespace loopstone
