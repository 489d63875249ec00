#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "formats/recording.hpp"
#include "formats/topic_survey.hpp"
#include "formats/wheel_angle.hpp"
#include "formats/wheel_messages.hpp"
#include "formats/wheel_plan.hpp"
#include "formats/wheel_sums.hpp"
#include "loopstone/sensor/messages.hpp"

namespace loopstone {

/// Makes readings of all wheels from the messages that tell of them; WheelPlan::model says how far
/// a count of them is.
class WheelStream {
 public:
  /// Both must outlive it.
  WheelStream(const WheelPlan& plan, const Recording& recording, const TopicSurvey& survey);

  /// Decodes a message, which add() is to take; its own stamp, 0 where it has none. Throws
  /// MessageError.
  /// \param topic  in the survey
  [[nodiscard]] Stamp read(const RecordedMessage& message, std::size_t topic);
  /// What was read, at the time that counts; the readings that are complete with it. The stamps of
  /// these may be earlier.
  [[nodiscard]] std::vector<WheelTicks> add(Stamp stamp);

  [[nodiscard]] std::vector<std::string> notes() const;

 private:
  using Wheel = std::variant<WheelAngle, WheelCount>;
  [[nodiscard]] std::optional<std::size_t> place_of(const ToldWheel& told) const;
  void take(std::size_t place, const ToldWheel& told, Stamp stamp);
  [[nodiscard]] double rolled(std::size_t place) const;

  const WheelPlan* plan_;
  WheelMessages messages_;
  const WheelMessage* told_ = nullptr;
  std::size_t topic_ = 0;  ///< of what was read
  std::vector<Wheel> wheels_{};
  std::vector<double> counts_a_turn_{};  ///< of each; 0: its counts are not angles
  double most_per_second_;               ///< counts of the readings
  WheelSums sums_;
  bool by_speed_ = false;
};

}  // namespace loopstone
