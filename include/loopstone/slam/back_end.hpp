#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/slam/finished_submap.hpp"
#include "loopstone/slam/key_chain.hpp"
#include "loopstone/slam/loop_closer.hpp"
#include "loopstone/slam/loop_closure.hpp"
#include "loopstone/slam/map_options.hpp"
#include "loopstone/slam/map_snapshot.hpp"
#include "loopstone/slam/map_update.hpp"

namespace loopstone {

/// Keeps the graph: key scans in a chain, closures across it, solved whenever a closure was found.
/// Depends only on what it is given and in which order, so it may run beside the front end.
///
/// Memory: grows with the area, not with time. What older submaps cover is thinned: of such a
/// stretch the first key scan stays, some hundred bytes for metres of travel.
class BackEnd {
 public:
  BackEnd(const MapOptions& options, Threads threads);

  void add_key(const KeyScan& key);
  /// Submaps come in the order of the key scans that they start with.
  void add_submap(FinishedSubmap submap);
  /// Looks once more for closures everywhere, settles which stand, and makes the graph of all key
  /// scans. Call once, at the end.
  void finish(const std::function<bool()>& goes_on = {});

  /// The stretches thinned since the last call: only their first key scans are still of use.
  [[nodiscard]] std::vector<std::size_t> take_thinned();

  /// What happened since the last call, in order: submaps dropped, closures, solutions.
  [[nodiscard]] std::vector<MapEvent> take_events() { return std::exchange(events_, {}); }
  /// Of each stretch, the pose of its first key scan.
  [[nodiscard]] std::span<const Pose2> map_T_submap() const { return outline_.poses; }
  [[nodiscard]] SubmapState state_of(SubmapId submap) const;

  /// After finish().
  [[nodiscard]] const PoseGraph& graph() const { return graph_; }
  [[nodiscard]] std::vector<KeyScan> keys() const { return chain_.keys(); }  ///< the graph's nodes
  [[nodiscard]] std::size_t stretch_count() const { return chain_.stretch_count(); }
  [[nodiscard]] const std::vector<LoopClosure>& closures() const { return closures_; }
  [[nodiscard]] double path_length_m() const { return chain_.length_m(); }
  [[nodiscard]] std::size_t submap_count() const { return loops_.submap_count(); }
  [[nodiscard]] bool submaps_lie_within(double reach_m) const {
    return loops_.submaps_lie_within(reach_m);
  }
  [[nodiscard]] double loop_closing_s() const { return loop_closing_s_; }
  [[nodiscard]] double optimisation_s() const { return optimisation_s_; }

  template <typename Archive>
  void archive(Archive& a) {
    a(loops_, chain_, outline_, graph_, closures_, thinned_, loop_closing_s_, optimisation_s_);
    if constexpr (Archive::kReads) a.check(is_sound(), "a graph that contradicts itself");
  }

 private:
  [[nodiscard]] bool is_sound() const;
  void take(std::vector<LoopClosure> found);
  void thin_covered();
  void accept_lone();
  [[nodiscard]] double unsolved_chi2() const;
  void solve(PoseGraph& graph);
  void solve_outline();

  bool loop_closure_;
  LoopCloser loops_;
  KeyChain chain_;
  PoseGraph outline_{};  ///< a node a stretch, and edges along the path; closures live in closures_
  PoseGraph graph_{};    ///< in the end: of all key scans, and with closures
  std::vector<LoopClosure> closures_{};
  std::vector<std::size_t> thinned_{};
  std::vector<MapEvent> events_{};
  double loop_closing_s_ = 0.0;
  double optimisation_s_ = 0.0;
};

}  // namespace loopstone
