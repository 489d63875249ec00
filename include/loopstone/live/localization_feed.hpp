#pragma once

#include <memory>
#include <string>

#include "loopstone/live/map_feed.hpp"
#include "loopstone/live/view_board.hpp"
#include "loopstone/localization/localization_map.hpp"
#include "loopstone/localization/localization_result.hpp"
#include "loopstone/localization/localizer.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/robot_model.hpp"

namespace loopstone {

/// Shows on a board where a localiser believes a robot to be.
///
///   LocalizationFeed feed(board, robot, map);
///   while (auto message = source.next()) {
///     feed.add(*message);
///     localizer.add(*message);
///     while (auto estimate = localizer.next_update()) feed.add(*estimate, localizer);
///   }
///
/// Of ViewPeriods `robot_s`, `status_s` and `map_s` are used, the last for particles and path.
/// Calls come from one thread at a time, and cost microseconds, or some tenths of a millisecond
/// where particles are shown.
class LocalizationFeed {
 public:
  LocalizationFeed(ViewBoard& board, const RobotModel& robot, const LocalizationMap& map,
                   const ViewPeriods& periods = {});
  ~LocalizationFeed();
  LocalizationFeed(const LocalizationFeed&) = delete;
  LocalizationFeed& operator=(const LocalizationFeed&) = delete;

  /// What the localiser is given. Of it scans are shown.
  void add(const SensorMessage& message);
  /// Each of its estimates, in their order.
  void add(const LocalizationEstimate& estimate, const Localizer& localizer);
  /// What no estimate tells: of where the messages come from.
  void add_warning(const std::string& text);
  /// While nothing comes: shows what was held back because it came too soon after what was shown.
  void catch_up(const Localizer& localizer);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace loopstone
