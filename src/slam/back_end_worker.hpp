#pragma once

#include <cstddef>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "loopstone/base/state_chunk.hpp"
#include "loopstone/slam/back_end.hpp"
#include "slam/map_board.hpp"
#include "slam/scan_store.hpp"
#include "slam/task_queue.hpp"

namespace loopstone {

/// The back end and the scans that it decides about, on a thread of its own. What it is given comes
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

  /// These chunks, and what the back end and its scans are after all that was handed over until
  /// now.
  [[nodiscard]] std::future<std::vector<StateChunk>> add_state(std::vector<StateChunk> chunks);
  void restore(std::span<const StateChunk> chunks);
  /// After restore(): whether the scans are those of the key scans, and all among the first
  /// `scans`.
  [[nodiscard]] bool scans_fit(std::size_t scans) const;
  /// After that: puts the map so far on the board.
  void show_restored();

  /// Waits for all that was handed over and ends the back end.
  /// \param goes_on  asked from the worker's thread
  void finish(const std::function<bool()>& goes_on);
  /// After finish().
  [[nodiscard]] const BackEnd& back_end() const { return back_end_; }
  [[nodiscard]] const ScanStore& scans() const { return scans_; }

 private:
  struct Step {
    std::shared_ptr<const MappedScan> scan{};
    std::optional<KeyScan> key{};

    template <typename Archive>
    void archive(Archive& a) {
      if constexpr (Archive::kReads) {
        MappedScan read;
        a(read, key);
        scan = std::make_shared<const MappedScan>(std::move(read));
      } else {
        a(*scan, key);
      }
    }
  };
  struct Batch {
    std::vector<Step> steps{};
    std::vector<FinishedSubmap> submaps{};
  };

  void take(Batch batch);
  void publish();

  MapBoard& board_;
  BackEnd back_end_;
  ScanStore scans_{};
  std::vector<Step> waiting_{};
  TaskQueue queue_{};
};

}  // namespace loopstone
