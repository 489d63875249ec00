#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "app.hpp"
#include "loopstone/formats/log_scan.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/registration/align.hpp"
#include "loopstone/sensor/point_cloud.hpp"

namespace loopstone::app {

/// One side of a match: exactly one of scan, cloud and map is there.
struct MatchInput {
  std::string name;
  std::optional<LogScan> scan{};
  std::optional<PointCloud> cloud{};
  std::optional<CellStates> map{};

  [[nodiscard]] bool planar() const { return !cloud || cloud->planar; }
  /// Finite points: a scan's in the robot's frame, sweep undone; a cloud's x and y; a map's visible
  /// walls.
  [[nodiscard]] std::vector<Eigen::Vector2d> points2() const;
  /// Of a cloud.
  [[nodiscard]] std::vector<Eigen::Vector3d> points3() const;
  /// Of a scan.
  [[nodiscard]] RobotScan robot_scan() const;
  /// "scan 120 at 1012.000000000, 1043 points".
  [[nodiscard]] std::string description() const;
  /// "scan", "cloud" or "map".
  [[nodiscard]] std::string kind() const;
};

/// Reads LOG#index, LOG@time, a point cloud or a map, told apart by the name. Throws UsageError for
/// a log without a scan.
[[nodiscard]] MatchInput read_match_input(const std::string& name, const AppContext& context);

}  // namespace loopstone::app
