#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/geometry/angle.hpp"
#include "topic_samples.hpp"

// Recordings of robots whose wheels are told by messages of all kinds.

namespace loopstone::test {

/// A message of CDR, little-endian, field by field.
class CdrMessage {
 public:
  CdrMessage() : bytes_("\0\1\0\0", 4) {}

  template <typename T>
  CdrMessage& put(T value) {
    while ((bytes_.size() - 4) % sizeof value != 0) bytes_ += '\0';
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes_.append(raw, sizeof value);
    return *this;
  }
  CdrMessage& text(const std::string& value) {
    put(static_cast<std::uint32_t>(value.size() + 1));
    bytes_ += value + '\0';
    return *this;
  }
  CdrMessage& header(Stamp stamp, const std::string& frame = "base_link") {
    constexpr std::int64_t kSecond = 1'000'000'000;
    put(static_cast<std::int32_t>(stamp.nanoseconds / kSecond));
    put(static_cast<std::uint32_t>(stamp.nanoseconds % kSecond));
    return text(frame);
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// The definition of a message with a header and these fields, as a recording of ROS 2 has it.
[[nodiscard]] inline MessageDefinition with_header(const std::string& fields) {
  return {DefinitionLanguage::kRos2Msg,
          "std_msgs/Header header\n" + fields + std::string(80, '=') +
              "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"};
}
[[nodiscard]] inline MessageDefinition of_fields(const std::string& fields) {
  return {DefinitionLanguage::kRos2Msg, fields};
}

/// Adds a message of a type that is known by its definition alone.
inline void add_raw(ToldTopics& told, const std::string& name, const std::string& type,
                    const MessageDefinition& definition, Stamp recorded,
                    const CdrMessage& message) {
  std::size_t topic = 0;
  while (topic < told.topics.size() && told.topics[topic].name != name) ++topic;
  if (topic == told.topics.size()) {
    told.topics.push_back({.name = name, .type = type, .definition = definition});
  }
  told.messages.push_back({topic, recorded, message.bytes()});
}

/// A robot with wheels of 0.1 m radius, 0.5 m apart, whose left side rolls at `left_m_s`.
struct RollingRobot {
  static constexpr double kRadiusM = 0.1;
  static constexpr double kTrackM = 0.5;
  static constexpr double kRateHz = 20.0;
  static constexpr int kReadings = 200;
  double left_m_s = 0.3;
  double right_m_s = 0.5;

  [[nodiscard]] static double time_s(int reading) { return reading / kRateHz; }
  /// It stands for a second first.
  [[nodiscard]] static double rolling_s(double t) { return std::max(0.0, t - 1.0); }
  [[nodiscard]] double left_m(double t) const { return left_m_s * rolling_s(t); }
  [[nodiscard]] double right_m(double t) const { return right_m_s * rolling_s(t); }
  [[nodiscard]] static double last_s() { return time_s(kReadings - 1); }
};

/// Scans of a laser, and frames of the robot and its wheels.
[[nodiscard]] inline ToldTopics scans_and_frames(bool wheel_frames, bool footprint = true) {
  ToldTopics told;
  const auto fixed = [&](const std::string& parent, const std::string& child, double x, double y,
                         double z) {
    told.tf("/tf_static", today(0), parent, child, mount(x, y, z, 0, 0, 0));
  };
  fixed("base_link", "laser", 0.2, 0.0, 0.3);
  if (footprint) fixed("base_footprint", "base_link", 0.0, 0.0, 0.04);
  if (wheel_frames) {
    fixed("base_link", "wheel_left_link", 0.0, 0.25, 0.06);
    fixed("base_link", "wheel_right_link", 0.0, -0.25, 0.06);
  }
  for (int i = 0; i < 100; ++i) told.scan("/scan", today(0.1 * i), "laser");
  return told;
}

inline void put_in_order(ToldTopics& told) {
  std::ranges::stable_sort(told.messages, {}, &ToldTopics::Message::recorded);
}

struct Rolled {
  double left = 0.0;
  double right = 0.0;
};

/// What the readings of a log add up to [m].
[[nodiscard]] inline Rolled rolled_m(const ToldLog& log) {
  Rolled sum;
  for (const WheelTicks& ticks : log.content.ticks) {
    sum.right += 0.5 * static_cast<double>(ticks.counts[0] + ticks.counts[2]);
    sum.left += 0.5 * static_cast<double>(ticks.counts[1] + ticks.counts[3]);
  }
  const double metres = log.robot.wheels.metres_per_count;
  return {metres * sum.left, metres * sum.right};
}

}  // namespace loopstone::test
