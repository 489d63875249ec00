#pragma once

#include <optional>
#include <string>
#include <vector>

#include "formats/recording.hpp"
#include "formats/wheel_names.hpp"

namespace loopstone {

/// What the numbers of a wheel are.
enum class WheelUnit {
  kRadians,           ///< how far it turned
  kCounts,            ///< of an encoder
  kRadiansPerSecond,  ///< how fast it turns
};

/// A field of a message that tells of a wheel.
struct WheelField {
  std::string path{};               ///< as AnyMessageDecoder names it
  std::optional<WheelSpot> spot{};  ///< nothing: the topic's name has to tell
  WheelUnit unit = WheelUnit::kCounts;
  int bits = 62;             ///< of a count: where it wraps
  std::string resolution{};  ///< path of the counts a turn; empty when the message has none
};

/// What a message type tells of wheels.
struct WheelFields {
  std::vector<WheelField> fields{};  ///< none: the type is something else
  MessageDefinition definition{};    ///< by which its messages are read
};

/// By the names and types of the fields in a topic's definition. Of common types whose definition
/// is missing, as in recordings of ROS 2 before Iron, it is known. Cost: linear in the definition.
[[nodiscard]] WheelFields wheel_fields(const RecordedTopic& topic);

}  // namespace loopstone
