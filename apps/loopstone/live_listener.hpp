#pragma once

#include <optional>

#include "loopstone/live/live_log.hpp"
#include "loopstone/localization/localization_map.hpp"
#include "loopstone/localization/localizer.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/robot_model.hpp"
#include "loopstone/slam/map_result.hpp"
#include "loopstone/slam/map_update.hpp"
#include "loopstone/slam/mapper.hpp"

namespace loopstone::app {

/// Who else hears of a live drive than the view and the files, and may have a say in it. Calls come
/// from one thread; none may take the run with it.
class LiveListener {
 public:
  LiveListener() = default;
  virtual ~LiveListener() = default;
  LiveListener(const LiveListener&) = delete;
  LiveListener& operator=(const LiveListener&) = delete;

  // Once, by what the drive is for.
  virtual void mapping_begins(const RobotModel& robot, const OccupancyOptions& map) = 0;
  virtual void localizing_begins(const LocalizationMap& map) = 0;

  /// Each message, before it is used.
  virtual void add(const SensorMessage& message) = 0;
  virtual void add(const MapUpdate& update, const Mapper& mapper) = 0;
  virtual void add(const LocalizationEstimate& estimate) = 0;
  /// What befalls a source.
  virtual void add(const LiveNews& news) = 0;
  /// Some twenty times a second while nothing comes. \param mapper  null while localising
  virtual void catch_up(const Mapper* mapper) = 0;
  /// Where somebody has said since the last call that the robot is.
  [[nodiscard]] virtual std::optional<InitialPose> take_initial_pose() = 0;

  /// The last message was added to the mapper.
  virtual void end(const Mapper& mapper) = 0;
  virtual void finish(const MapResult& result) = 0;
};

}  // namespace loopstone::app
