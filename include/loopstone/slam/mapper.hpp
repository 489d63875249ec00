#pragma once

#include <deque>
#include <future>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/base/progress.hpp"
#include "loopstone/base/stamp.hpp"
#include "loopstone/base/state_chunk.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/odometry/scan_queue.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/robot_model.hpp"
#include "loopstone/sensor/scan_points.hpp"
#include "loopstone/slam/front_end.hpp"
#include "loopstone/slam/key_chain.hpp"
#include "loopstone/slam/map_options.hpp"
#include "loopstone/slam/map_result.hpp"

namespace loopstone {

/// Turns a stream of sensor messages into a trajectory, a pose graph and a map.
///
///   Mapper mapper(robot, options, threads);
///   while (auto message = log.next()) mapper.add(*message);
///   MapResult result = mapper.finish();
///
/// The result is the same bytes for any number of threads.
class Mapper {
 public:
  Mapper(const RobotModel& robot, const MapOptions& options, Threads threads = {});
  ~Mapper();

  /// Messages come in time order. A scan is worked on once odometry for its time has come, or after a moment's wait.
  void add(const SensorMessage& message);

  /// Ends the recording: last closures, last solution, the final map of all scans. Call once. A map that is too large leaves all
  /// else and says so in `map_failure`.
  /// \param progress  told before each stage and while loops are closed, maybe from another thread but never from two at once; once
  ///                  it returns false, the last search for loops ends, what only refines or judges the map is left out, and the
  ///                  result is marked incomplete
  [[nodiscard]] MapResult finish(const ProgressCallback& progress = {});

  /// Everything that the messages so far have led to. A new mapper of the same robot and options that is given it goes on to
  /// the same bytes. Returns once the front end is saved; the rest follows when the back end has come as far, on its thread.
  [[nodiscard]] std::future<std::vector<StateChunk>> save_state();
  /// Before the first message. Throws DataError when a part is missing, of another version or damaged; this mapper is of no
  /// use then.
  void restore_state(std::span<const StateChunk> chunks);

  template <typename Archive>
  void archive(Archive& a) {
    a(track_, last_mapped_, statistics_, gyro_scans_, breaks_);
  }

  [[nodiscard]] std::int64_t scans() const { return static_cast<std::int64_t>(track_.size()); }

 private:
  /// What is kept of every scan.
  struct TrackedPose {
    Stamp stamp{};
    Pose2 local_T_robot{};
    std::optional<Pose2> odom_T_robot{};

    template <typename Archive>
    void archive(Archive& a) {
      a(stamp, local_T_robot, odom_T_robot);
    }
  };
  class BackEndWorker;

  void add_scan(LaserScan scan);
  [[nodiscard]] Pose2 end_of_sweep(const LaserScan& scan, const Pose2& local_T_robot) const;
  void hand_over(LaserScan scan, const Pose2& robot_T_lidar, TrackedScan tracked);
  /// Of each key scan, its own frame.
  [[nodiscard]] std::vector<std::vector<SurfacePoint>> key_surfaces(
      std::span<const KeyScan> keys) const;
  void report_sensors(MapResult& result) const;
  void adjust(std::span<const KeyScan> keys, MapResult& result) const;
  [[nodiscard]] std::vector<PosedScan> place_scans(std::vector<KeyScan> keys,
                                                   MapResult& result) const;
  static void count(MapResult& result);

  RobotModel robot_;
  MapOptions options_;
  Threads threads_;
  ScanQueue scan_queue_;
  FrontEnd front_end_;
  std::unique_ptr<BackEndWorker> back_end_;
  std::deque<TrackedPose> track_{};
  Pose2 last_mapped_{};
  MapStatistics statistics_{};
  std::int64_t gyro_scans_ = 0;  ///< whose heading alone was known
  std::vector<PathBreak> breaks_{};
};

}  // namespace loopstone
