#pragma once

#include <span>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/base/stamp.hpp"
#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/slam/loop_closer.hpp"
#include "loopstone/slam/map_options.hpp"
#include "loopstone/slam/map_result.hpp"

namespace loopstone {

/// A scan that is a node of the graph.
struct KeyScan {
  Stamp stamp;
  Pose2 local_T_robot;  ///< where the front end put it
  Eigen::Matrix3d covariance =
      Eigen::Matrix3d::Zero();  ///< of that match, (x, y, yaw), local frame
};

/// Keeps the graph: key scans in a chain, closures across it, solved whenever a closure was found.
/// Depends only on what it is given and in which order, so it may run beside the front end.
class BackEnd {
 public:
  BackEnd(const MapOptions& options, Threads threads);

  void add_key(const KeyScan& key);
  void add_submap(FinishedSubmap submap);
  /// Looks once more for closures everywhere and settles which stand. Call once, at the end.
  void finish();

  [[nodiscard]] const PoseGraph& graph() const { return graph_; }
  [[nodiscard]] const std::vector<LoopClosure>& closures() const { return closures_; }
  [[nodiscard]] std::size_t submap_count() const { return loops_.submap_count(); }
  [[nodiscard]] double loop_closing_s() const { return loop_closing_s_; }
  [[nodiscard]] double optimisation_s() const { return optimisation_s_; }

 private:
  void take(std::vector<LoopClosure> found);
  void accept_lone();
  void solve();

  bool loop_closure_;
  LoopCloser loops_;
  PoseGraph graph_{};  ///< chain edges only, closures live in closures_
  std::vector<KeyScan> keys_{};
  std::vector<double> travelled_m_{};
  std::vector<LoopClosure> closures_{};
  double loop_closing_s_ = 0.0;
  double optimisation_s_ = 0.0;
};

}  // namespace loopstone
