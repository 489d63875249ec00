#pragma once

#include <cstddef>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "loopstone/slam/back_end.hpp"
#include "loopstone/slam/mapper_state.hpp"
#include "slam/map_board.hpp"
#include "slam/task_queue.hpp"

namespace loopstone {

/// The back end on a thread of its own. What it is given comes
/// in an order that does not depend on how fast it is, and nothing of it flows back into the front
/// end: so the result is the same however both threads take turns.
class BackEndWorker {
 public:
  /// \param board  where the map so far is put up; outlives the worker
  BackEndWorker(const MapOptions& options, Threads threads, MapBoard& board);

  /// Handed over with the next submap: a thread that wakes for every scan costs more than it does.
  void add_scan(MappedScan scan, const std::optional<KeyScan>& key);
  /// Waits only when it has fallen behind by several submaps.
  void add_submaps(std::vector<FinishedSubmap> submaps);

  /// Adds what the back end is after all that was handed over until now, and the scans that wait.
  [[nodiscard]] std::future<MapperState> add_state(MapperState state);
  /// From a sound state; puts the map so far on the board.
  void restore(BackEnd::State state, std::vector<WaitingScan> waiting);

  /// Until all that was handed over is worked on; scans that no submap followed wait on.
  void wait() { queue_.wait(); }
  /// Waits for all that was handed over and ends the back end.
  /// \param goes_on  asked from the worker's thread
  void finish(const std::function<bool()>& goes_on);
  /// After finish() or wait().
  [[nodiscard]] const BackEnd& back_end() const { return back_end_; }

 private:
  struct Batch {
    std::vector<WaitingScan> scans{};
    std::vector<FinishedSubmap> submaps{};
  };

  void take(Batch batch);
  void publish();

  MapBoard& board_;
  BackEnd back_end_;
  std::size_t taken_ = 0;  ///< scans
  std::vector<WaitingScan> waiting_{};
  TaskQueue queue_{};
};

}  // namespace loopstone
