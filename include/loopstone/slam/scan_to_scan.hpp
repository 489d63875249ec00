#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "loopstone/base/options.hpp"
#include "loopstone/base/parallel_for.hpp"
#include "loopstone/base/progress.hpp"
#include "loopstone/graph/solver.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/odometry/scan_queue.hpp"
#include "loopstone/registration/icp.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/robot_model.hpp"
#include "loopstone/slam/map_result.hpp"

namespace loopstone {

/// Options of the textbook pipeline.
struct ScanToScanOptions {
  int interval = 10;
  bool interval_all = false;
  double node_distance_m = 0.0;
  double node_angle_rad = 0.0;
  double point_spacing_m = 0.03;
  /// Odometry is a good guess: what is farther away belongs to something else.
  IcpOptions icp{.max_pair_distance_m = 0.5};
  SolverOptions solver{};
  OccupancyOptions map{};
};

template <typename Visitor>
void visit_options(ScanToScanOptions& options, Visitor&& visit) {
  visit("interval", options.interval, Range{0, 10000},
        "every so many nodes an edge from the node so many before; 0: none");
  visit("interval_all", options.interval_all, "also edges from all nodes in between to the last");
  visit("node_distance_m", options.node_distance_m, Range{0.0, 10.0},
        "a scan becomes a node when the robot moved this far; 0: every scan");
  visit("node_angle_rad", options.node_angle_rad, Range{0.0, 3.2},
        "a scan becomes a node when the robot turned this far; 0: every scan");
  visit("point_spacing_m", options.point_spacing_m, Range{0.0, 1.0},
        "points of a scan nearer to the last one kept are left out");
  visit.group("icp", options.icp);
  visit.group("solver", options.solver);
  visit.group("map", options.map);
}

/// The pipeline of textbooks, as the baseline that others are compared with: dead reckoning; ICP
/// between consecutive scans, started from odometry; ICP over fixed intervals; a pose graph of
/// both, solved by Gauss-Newton; the map of all scans. It never looks for places seen before.
///
///   ScanToScanMapper mapper(robot, options, threads);
///   while (auto message = log.next()) mapper.add(*message);
///   MapResult result = mapper.finish(progress);
///
/// Where ICP fails (too few pairs, no convergence, far from odometry) odometry stands in; without
/// odometry the motion of the pair before. The result is the same bytes for any number of threads.
/// Keeps all scans in memory.
/// Cost: O(scans * points * log points), about 1 ms a scan.
/// Source: Lu and Milios 1997, "Globally consistent range scan alignment for environment mapping".
class ScanToScanMapper {
 public:
  /// Throws OptionsError with everything that is wrong with the options.
  explicit ScanToScanMapper(const RobotModel& robot, const ScanToScanOptions& options = {},
                            Threads threads = {});

  /// Messages come in time order. A scan waits until odometry for its time has come, at most 0.25
  /// s.
  void add(const SensorMessage& message);

  /// Matches, solves and draws. Call once. When progress asks to stop, the scans matched so far are
  /// solved and drawn and the result is marked incomplete.
  [[nodiscard]] MapResult finish(const ProgressCallback& progress = {});

  [[nodiscard]] std::int64_t scans() const { return static_cast<std::int64_t>(records_.size()); }

 private:
  /// A scan, and which node it hangs on.
  struct Record {
    LaserScan scan;
    Pose2 robot_T_lidar;
    std::optional<Pose2> odom_T_robot;
    Tangent2 velocity;   ///< [m/s, m/s, rad/s], by odometry
    int node = -1;       ///< -1: too few returns, left out
    Pose2 node_T_robot;  ///< identity when it is the node
  };
  /// A scan of the graph.
  struct Node {
    Stamp stamp;
    std::size_t record;
    std::vector<Eigen::Vector2d> points;               ///< robot frame
    std::optional<PoseWithCovariance2> before_T_node;  ///< from the node before, by odometry
  };
  struct Links;

  void take(LaserScan scan);
  [[nodiscard]] bool is_node(const Record& record) const;
  [[nodiscard]] Links match_consecutive(const ProgressCallback& progress) const;
  void match_intervals(Links& links, const ProgressCallback& progress) const;
  [[nodiscard]] MapResult assemble(const Links& links) const;
  /// Not solved yet.
  [[nodiscard]] PoseGraph graph_of(const Links& links) const;
  /// Where the result's graph has them; its trajectories too.
  [[nodiscard]] std::vector<PosedScan> place_scans(const Links& links, MapResult& result) const;
  /// The map, and what it is worth.
  void draw(const std::vector<PosedScan>& posed, MapResult& result) const;

  RobotModel robot_;
  ScanToScanOptions options_;
  Threads threads_;
  ScanQueue scan_queue_;
  std::vector<Record> records_{};
  std::vector<Node> nodes_{};
  std::int64_t dropped_ = 0;
};

}  // namespace loopstone
