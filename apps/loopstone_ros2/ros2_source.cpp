#include "ros2_source.hpp"

#include <algorithm>
#include <chrono>
#include <deque>
#include <functional>
#include <set>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/base/words.hpp"
#include "loopstone/messages/message_types.hpp"

namespace loopstone::app {

namespace {

constexpr std::chrono::milliseconds kPatience{50};
constexpr const char* kMounts = "/tf_static";
/// What came before all was there that is waited for: so much of it is used.
constexpr Duration kHeld = Duration::from_milliseconds(2000);
constexpr std::size_t kMostHeld = 4000;  ///< messages

/// What goes with a scan comes before it.
std::vector<RosTopic> topics_to_read(const SensorTopics& topics) {
  constexpr TopicQuality kSensor{.depth = 1000};
  std::vector<RosTopic> all{
      ros_topic<msg::TFMessage>(kMounts, {.is_reliable = true, .is_latched = true, .depth = 1000}),
      ros_topic<msg::TFMessage>("/tf", kSensor)};
  for (const std::string& name : topics.odometry)
    all.push_back(ros_topic<msg::Odometry>(name, kSensor));
  for (const std::string& name : topics.imu) all.push_back(ros_topic<msg::Imu>(name, kSensor));
  for (const std::string& name : topics.scans)
    all.push_back(ros_topic<msg::LaserScan>(name, {.depth = 100}));
  return all;
}

/// What comes, from a little before all topics were there that are waited for.
class Sensors {
 public:
  Sensors(const DdsNode& node, const SensorTopics& topics)
      : inbox_(node, topics_to_read(topics)),
        awaited_(topics.awaited.begin(), topics.awaited.end()) {}

  /// Throws ReadingStopped.
  void wait_for_all(const std::function<bool()>& stop) {
    while (!awaited_.empty()) {
      if (stop && stop()) throw ReadingStopped();
      auto message = inbox_.take(kPatience);
      if (!message) continue;
      awaited_.erase(message->topic);
      held_.push_back(std::move(*message));
      const auto is_old = [&](const CameMessage& one) {
        return one.topic != kMounts && held_.back().received - one.received > kHeld;
      };
      std::erase_if(held_, is_old);
      if (held_.size() > kMostHeld) held_.pop_front();
    }
  }
  [[nodiscard]] std::optional<CameMessage> take() {
    if (held_.empty()) return inbox_.take(kPatience);
    CameMessage message = std::move(held_.front());
    held_.pop_front();
    return message;
  }

 private:
  DdsInbox inbox_;
  std::set<std::string> awaited_;
  std::deque<CameMessage> held_{};
};

}  // namespace

SensorTopics sensor_topics(const TopicOptions& options) {
  SensorTopics topics;
  std::set<TopicRole> named;
  for (const auto& [role, name] : options.named) {
    std::vector<std::string>* const names = role == TopicRole::kLaser      ? &topics.scans
                                            : role == TopicRole::kOdometry ? &topics.odometry
                                            : role == TopicRole::kImu      ? &topics.imu
                                                                           : nullptr;
    if (names == nullptr) {
      throw UsageError("--topic " + std::string(to_string(role)) + "=" + name +
                       ": of a network laser, odometry and imu are read");
    }
    if (named.insert(role).second) names->clear();  // of the default
    if (name.empty()) continue;
    names->push_back(name);
    topics.awaited.push_back(name);
  }
  if (topics.scans.empty()) throw UsageError("--topic laser=: nothing can be done without a laser");
  if (!named.contains(TopicRole::kLaser))
    topics.awaited.insert(topics.awaited.end(), topics.scans.begin(), topics.scans.end());
  return topics;
}

LiveSource ros2_source(const DdsNode& node, const std::string& name, const SensorTopics& topics) {
  return {.name = name,
          .open =
              [&node, name, topics](const LogOptions& how) {
                const auto sensors = std::make_shared<Sensors>(node, topics);
                sensors->wait_for_all(how.stop);
                return open_message_log(
                    name, [sensors] { return sensors->take(); }, how);
              },
          .waits = false};
}

}  // namespace loopstone::app
