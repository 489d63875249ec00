#include "formats/recording_plan.hpp"

#include <utility>

namespace loopstone {
namespace {

/// The topics whose clocks are held against the first one's.
std::vector<std::size_t> timed_topics(const TopicChoice& choice, const WheelPlan& wheels) {
  std::vector<std::size_t> topics;
  for (const ChosenLaser& laser : choice.lasers) topics.push_back(laser.topic);
  if (choice.odometry && choice.odometry->topic) topics.push_back(*choice.odometry->topic);
  if (choice.imu) topics.push_back(*choice.imu);
  if (choice.wheels) topics.push_back(*choice.wheels);
  for (const std::size_t topic : wheels.topics()) topics.push_back(topic);
  if (choice.camera) {
    topics.push_back(choice.camera->depth);
    topics.push_back(choice.camera->colour);
  }
  return topics;
}

/// Of the frame that odometry moves, or else of any.
const MovingFrame* leading_frame(const TopicSurvey& survey, const TopicChoice& choice) {
  for (const MovingFrame& frame : survey.moving) {
    if (choice.odometry && frame.child == choice.odometry->child) return &frame;
  }
  return survey.moving.empty() ? nullptr : &survey.moving.front();
}

}  // namespace

RecordingPlan plan_recording(Recording& recording, const LogOptions& options) {
  RecordingPlan result;
  result.survey = survey_topics(recording, options.topics.pictures);
  result.choice = choose_topics(result.survey, options.topics);
  result.wheels = plan_wheels(recording, options.topics, result.survey, result.choice);
  std::vector<ClockQuestion> questions;
  const std::vector<std::size_t> timed = timed_topics(result.choice, result.wheels);
  for (const std::size_t i : timed) {
    questions.push_back({result.survey.topics[i].name, &result.survey.topics[i].stamps});
  }
  const MovingFrame* const frame = leading_frame(result.survey, result.choice);
  if (frame != nullptr) {
    // Publishers of mounts and of maps tell ahead for how long they are right.
    const bool is_odometry =
        result.choice.odometry && frame->child == result.choice.odometry->child;
    questions.push_back({"tf of " + frame->child, &frame->stamps, !is_odometry});
  }
  result.clocks = choose_clocks(questions, options.stamps);
  result.clock_of.assign(result.survey.topics.size(), {});
  for (std::size_t k = 0; k < timed.size(); ++k)
    result.clock_of[timed[k]] = result.clocks.clocks[k];
  if (frame != nullptr) result.tf_clock = result.clocks.clocks.back();
  for (const std::size_t topic : result.wheels.topics()) {
    if (result.clock_of[topic].source != TopicClock::Source::kOrder) continue;
    drop_wheels("wheels need stamps", result.survey, result.wheels, result.choice);
    break;
  }
  return result;
}

RecordingOptions recording_options(const LogOptions& options,
                                   std::function<void(const Problem&)> on_damage) {
  return {.memory = options.memory, .stop = options.stop, .on_damage = std::move(on_damage)};
}

}  // namespace loopstone
