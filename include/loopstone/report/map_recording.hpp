#pragma once

#include <memory>
#include <string>

#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/robot_model.hpp"
#include "loopstone/slam/map_result.hpp"
#include "loopstone/slam/map_update.hpp"
#include "loopstone/slam/mapper.hpp"

namespace loopstone {

/// A run of the mapper as an MCAP recording of ROS 2, to be watched: Foxglove and Lichtblick open
/// it, `ros2 bag play` plays it for RViz.
///
///   MapRecording recording("run.mcap", robot, options.map);
///   const auto take_updates = [&] {
///     while (auto update = mapper.next_update()) recording.add(*update, mapper);
///   };
///   while (auto message = source.next()) {
///     recording.add(*message);
///     mapper.add(*message);
///     take_updates();
///   }
///   MapResult result = mapper.finish();
///   take_updates();
///   recording.finish(result);
///
/// Its topics, all of standard types:
///
///   /scan, /scan_2, ...  sensor_msgs/LaserScan: every scan, in the frame of its laser
///   /tf_static           tf2_msgs/TFMessage: base_link to laser, laser_2, ...
///   /tf                  tf2_msgs/TFMessage: map to odom and odom to base_link at every scan, as
///                        they were known then
///   /map                 nav_msgs/OccupancyGrid: the map so far, whenever it has changed, at most
///                        once a second and a million cells a second
///   /path                nav_msgs/Path: the way so far as the graph has it, once a second
///   /submaps             visualization_msgs/MarkerArray: origins and numbers of the submaps
///   /loop_closures       visualization_msgs/MarkerArray: one list of lines a state; namespaces
///                        standing, waiting, rejected, revoked
///   /verdict             diagnostic_msgs/DiagnosticArray: what holds the pose and faults of
///                        sensors, as they begin and end; in the end, how good the map is
///
/// Times are those of the log. A millisecond after the last scan follows what the finished map
/// says: map, path, submaps, closures, verdict, and the transforms to where the path ends. What is
/// told before of loop closing depends on how fast the machine is.
///
/// The map so far is drawn here, up to 0.1 s a second of the log. Memory: 26 kB a tile of 3.2 m,
/// and a few bytes a cell of the map. One thread at a time.
class MapRecording {
 public:
  /// \param path   appears whole, by finish(), or not at all
  /// \param map    as the mapper's; of a map of more than `most_cells` only the finished one, which
  ///               has wider cells, is recorded
  /// Throws DataError when no file can be made there.
  MapRecording(const std::string& path, const RobotModel& robot, const OccupancyOptions& map = {});
  /// Without finish() removes what was written.
  ~MapRecording();
  MapRecording(const MapRecording&) = delete;
  MapRecording& operator=(const MapRecording&) = delete;

  /// What the mapper is given. Of it scans are recorded.
  /// Throws, as all below: DataError when it can't be written, MessageError for stamps that ROS 2
  /// has no place for (after 2038).
  void add(const SensorMessage& message);
  /// Each of the mapper's updates, in their order.
  /// \param mapper  whose snapshot is taken, once a second
  void add(const MapUpdate& update, const Mapper& mapper);
  /// The last call: completes the file and puts it in its place.
  void finish(const MapResult& result);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace loopstone
