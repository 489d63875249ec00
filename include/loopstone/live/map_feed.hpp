#pragma once

#include <memory>
#include <string>

#include "loopstone/live/view_board.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/robot_model.hpp"
#include "loopstone/slam/map_result.hpp"
#include "loopstone/slam/map_update.hpp"
#include "loopstone/slam/mapper.hpp"

namespace loopstone {

/// How often a view is told something at most, in seconds of this machine's clock; 0: whenever
/// there is something.
struct ViewPeriods {
  double robot_s = 1.0 / 30.0;  ///< pose, transform, scan
  double status_s = 0.1;
  double map_s = 0.2;       ///< tiles, path
  double closures_s = 0.5;  ///< closures, submaps
  double standard_s = 1.0;  ///< the map, path and graph as ROS has them, which are sent whole
};

/// Shows on a board what a mapper does.
///
///   MapFeed feed(board, robot, options.map);
///   while (auto message = source.next()) {
///     feed.add(*message);
///     mapper.add(*message);
///     while (auto update = mapper.next_update()) feed.add(*update, mapper);
///   }
///   feed.end(mapper);
///   feed.finish(mapper.finish());
///
/// The mapper's thread is kept for microseconds an update; the map is drawn, and all that is long
/// is written, on a thread of the feed's own. The mapper's result does not depend on it. As long as
/// nobody looks nothing is drawn. Calls come from one thread at a time.
class MapFeed {
 public:
  /// \param map  as the mapper's
  MapFeed(ViewBoard& board, const RobotModel& robot, const OccupancyOptions& map,
          const ViewPeriods& periods = {});
  ~MapFeed();
  MapFeed(const MapFeed&) = delete;
  MapFeed& operator=(const MapFeed&) = delete;

  /// Another mapper begins: what was shown is no more.
  void begin_anew(const RobotModel& robot);
  /// What the mapper is given. Of it scans are shown.
  void add(const SensorMessage& message);
  /// Each of the mapper's updates, in their order.
  void add(const MapUpdate& update, const Mapper& mapper);
  /// What no update tells: of where the messages come from.
  void add_warning(const std::string& text);
  /// So long the front end took for the last message.
  void note_front_end(double seconds);
  /// While nothing comes: shows what was held back because it came too soon after what was shown.
  /// To be called several times a second.
  void catch_up(const Mapper& mapper);
  /// The last message was added: what the mapper knows of scans and submaps is taken before it
  /// finishes.
  void end(const Mapper& mapper);
  /// The finished map takes the place of the one so far.
  void finish(const MapResult& result);
  /// Returns when all that was added is on the board.
  void flush();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace loopstone
