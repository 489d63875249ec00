#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/recording.hpp"
#include "formats/topic_survey.hpp"
#include "formats/wheel_fields.hpp"
#include "loopstone/messages/message_codec.hpp"

namespace loopstone {

/// What one message tells of one wheel, or of a joint that is none.
struct ToldWheel {
  std::string name{};                ///< of a joint; empty for a field
  WheelField field{};                ///< of joints only the unit
  std::optional<WheelSpot> spot{};   ///< nothing: no wheel
  std::optional<double> position{};  ///< [rad], or counts
  std::optional<double> speed{};     ///< [rad/s]
  double counts_a_turn = 0.0;        ///< 0: not told
};

struct WheelMessage {
  std::optional<Stamp> stamp{};  ///< of its header
  std::string frame{};
  std::vector<ToldWheel> wheels{};
};

/// Decodes messages of joints, and of types that wheel_fields() understands.
class WheelMessages {
 public:
  WheelMessages(const Recording& recording, const TopicSurvey& survey)
      : recording_(&recording), survey_(&survey) {}

  /// \param topic  of the message, in the survey
  /// The result is good until the next call. Throws MessageError.
  [[nodiscard]] const WheelMessage& decode(const RecordedMessage& message, std::size_t topic);

 private:
  struct ByDefinition {
    AnyMessageDecoder decoder;
    std::vector<WheelField> fields{};
  };
  void decode_joints(const RecordedMessage& message);
  void decode_fields(const RecordedMessage& message, const std::string& topic);

  const Recording* recording_;
  const TopicSurvey* survey_;
  std::map<std::size_t, MessageDecoder<msg::JointState>> joint_decoders_{};
  std::map<std::size_t, ByDefinition> decoders_{};
  msg::JointState joints_{};
  WheelMessage told_{};
};

}  // namespace loopstone
