#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "loopstone/slam/map_snapshot.hpp"
#include "loopstone/slam/map_update.hpp"

namespace loopstone {

/// What the back end knows at one moment. Never changes once it is on the board.
struct BackEndView {
  std::vector<SubmapSnapshot> submaps{};
  std::vector<LoopClosure> closures{};
  std::size_t scans_taken = 0;  ///< of all that were handed over
};

/// What sensors did wrong so far.
struct FaultView {
  std::optional<Stamp> first_scan{};
  std::vector<OdometryEpisode> odometry{};
  std::vector<LaserEpisode> laser{};
  std::vector<PathBreak> breaks{};
};

/// Where the front end and the back end put up what is known, each from its own thread, and where
/// anybody may read it. Every call holds a lock for as long as a few pointers take to copy.
class MapBoard {
 public:
  /// By the front end: a scan on its way to the back end.
  void add_scan(std::shared_ptr<const MappedScan> scan, bool starts_submap);
  void set_faults(FaultView faults);
  /// By the back end.
  void publish(BackEndView view, std::vector<MapEvent> events);

  /// What moves the front end's local frame onto the map, by the newest submap that was solved for.
  [[nodiscard]] Pose2 map_T_local() const;
  /// The back end's events since the last call.
  [[nodiscard]] std::vector<MapEvent> take_events();
  [[nodiscard]] MapSnapshot snapshot() const;

 private:
  struct OpenScan {
    std::shared_ptr<const MappedScan> scan;
    bool starts_submap;
  };

  mutable std::mutex mutex_{};
  std::shared_ptr<const BackEndView> view_ = std::make_shared<const BackEndView>();
  Pose2 map_T_local_{};
  std::deque<OpenScan> open_{};  ///< handed over, not yet in the view
  std::size_t open_from_ = 0;    ///< the number of the first of them
  std::vector<MapEvent> events_{};
  std::shared_ptr<const FaultView> faults_ = std::make_shared<const FaultView>();
};

}  // namespace loopstone
