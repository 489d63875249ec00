#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/formats/ros_map.hpp"
#include "loopstone/live/view_channel.hpp"
#include "loopstone/live/view_contents.hpp"
#include "loopstone/live/view_server.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/mapping/occupancy_tiles.hpp"
#include "loopstone/odometry/trajectory.hpp"
#include "loopstone/sensor/laser_scan.hpp"
#include "loopstone/sensor/robot_model.hpp"

namespace loopstone {

/// Where messages go. Called from any thread.
struct ViewSink {
  std::function<ChannelId(ViewChannel)> add_channel{};
  std::function<void(ChannelId, Stamp, std::string)> publish{};
  std::function<void(Stamp)> set_time{};
  /// Whether anybody looks; empty: it may be.
  std::function<bool()> is_watched{};
  /// Whether anybody takes a channel's messages; empty: it may be.
  std::function<bool(ChannelId)> is_wanted{};
};
[[nodiscard]] ViewSink sink_of(ViewServer& server);

/// A map and a robot on it, put into the messages of the live view (docs/live_view.md): what is
/// shown is sent when it differs from what was shown before, and whoever comes late gets all of it.
///
///   ViewServer server(options);
///   ViewBoard board(sink_of(server));
///   server.on_get([&](auto path) { return board.answer(path); });
///   server.start();
///   board.show_nodes(stamp, nodes);
///
/// How often is the caller's to say (MapFeed does). The server asks the board, so it must stop()
/// before the board goes. Safe to be called from any thread. Messages that no clock of ROS 2 has a
/// place for (after 2038) are left out.
class ViewBoard {
 public:
  explicit ViewBoard(ViewSink sink);
  ~ViewBoard();
  ViewBoard(const ViewBoard&) = delete;
  ViewBoard& operator=(const ViewBoard&) = delete;

  /// Whether anybody looks. What is costly to make need not be shown until then.
  [[nodiscard]] bool is_watched() const;
  /// Whether anybody takes what is sent whole for other programs: /map, /path or /graph.
  [[nodiscard]] bool is_standard_wanted() const;

  /// All that was shown is no more; tiles are of that resolution from now on.
  void begin_anew(Stamp stamp, double resolution_m);

  /// Also where the laser sits, when that is new.
  /// \param scan  null: none is at hand; what its robot tells of the laser is in it (as_mounted())
  void show_robot(Stamp stamp, const Pose2& map_T_robot, const Eigen::Matrix3d& covariance,
                  const LaserScan* scan, const RobotModel& robot);
  /// Where else it may be.
  void show_particles(Stamp stamp, const std::vector<Pose2>& map_T_robot);
  void show_status(const ViewStatus& status);

  void change_tiles(Stamp stamp, const std::vector<OccupancyTile>& tiles);
  void replace_tiles(Stamp stamp, const CellStates& cells);
  void replace_tiles(Stamp stamp, const OccupancyMap& map);
  /// Of all tiles [m^2].
  [[nodiscard]] double known_area_m2() const;
  void show_grid(Stamp stamp, const CellStates& cells);
  void show_nodes(Stamp stamp, std::vector<ViewNode> nodes);
  void show_path(Stamp stamp, const std::vector<StampedPose2>& poses);
  /// As lists, and, once the path is shown, as markers by show_graph().
  void show_closures(Stamp stamp, std::vector<ViewClosure> closures);
  void show_submaps(Stamp stamp, std::vector<ViewSubmap> submaps);
  void show_graph(Stamp stamp);
  void show_verdict(Stamp stamp, const ViewVerdict& verdict);
  void show_warnings(Stamp stamp, const std::vector<ViewWarning>& warnings);
  void show_quality(Stamp stamp, const ViewLayer& layer);
  void show_texture(Stamp stamp, const ViewLayer& layer);

  /// To GET of /api/closures/ID.
  [[nodiscard]] std::optional<HttpAnswer> answer(std::string_view path) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace loopstone
