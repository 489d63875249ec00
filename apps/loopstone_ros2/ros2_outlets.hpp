#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dds_node.hpp"
#include "live_listener.hpp"
#include "loopstone/live/map_feed.hpp"
#include "loopstone/live/view_board.hpp"
#include "loopstone/report/ros_messages.hpp"

namespace loopstone::app {

/// What the other programs of a robot are told of a drive: /map, /tf, /pose, /diagnostics; and
/// /initialpose, by which they say where the robot is while it is localised.
class Ros2Outlets final : public LiveListener {
 public:
  /// \param node  must outlive it
  Ros2Outlets(const DdsNode& node, RobotFrames frames);

  void mapping_begins(const RobotModel& robot, const OccupancyOptions& map) override;
  void localizing_begins(const LocalizationMap& map) override;
  void add(const SensorMessage& message) override { transforms_.add(message); }
  void add(const MapUpdate& update, const Mapper& mapper) override;
  void add(const LocalizationEstimate& estimate) override;
  void add(const LiveNews& news) override;
  void catch_up(const Mapper* mapper) override;
  [[nodiscard]] std::optional<InitialPose> take_initial_pose() override;
  void end(const Mapper& mapper) override;
  void finish(const MapResult& result) override;

 private:
  using Clock = std::chrono::steady_clock;

  void tell_place(Stamp stamp, const Pose2& map_T_robot, const Pose2& odom_T_robot,
                  const Eigen::Matrix3d& covariance);
  /// \return whether it is news
  bool note(msg::DiagnosticStatus status);
  void tell_diagnostics(bool is_news);

  const DdsNode& node_;
  RobotTransforms transforms_;
  DdsOutlet map_;
  DdsOutlet tf_;
  DdsOutlet pose_;
  DdsOutlet diagnostics_;
  std::unique_ptr<DdsInbox> initial_pose_{};
  std::map<std::string, msg::DiagnosticStatus> statuses_{};  ///< the last of each name
  std::optional<Clock::time_point> diagnosed_{};
  ViewBoard board_;
  std::unique_ptr<MapFeed> feed_{};  ///< draws the map on the board; goes before it
};

}  // namespace loopstone::app
