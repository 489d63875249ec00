#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <stop_token>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/base/progress.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/robot_model.hpp"
#include "loopstone/slam/graph_addition.hpp"
#include "loopstone/slam/map_options.hpp"
#include "loopstone/slam/map_result.hpp"
#include "loopstone/slam/map_snapshot.hpp"
#include "loopstone/slam/map_update.hpp"

namespace loopstone {

struct MapperState;
struct SettledMap;

/// What the mapper itself decides by.
struct MapperNumbers {
  double still_cells = 1.0;
  double still_rad = 0.04;
  double submap_travel_most_m = 300.0;
  double between_drives_s = 60.0;
  double beside_m = 100.0;
  std::size_t updates_most = 1000;
};
inline constexpr MapperNumbers kMapper{};

template <typename Visitor>
void visit_numbers(const MapperNumbers& n, Visitor&& visit) {
  visit("still_cells", n.still_cells,
        "chosen: a scan nearer to the last one mapped, in cells of the map, adds next to nothing "
        "to the final map");
  visit("still_rad", n.still_rad, "chosen: the same of the heading");
  visit("submap_travel_most_m", n.submap_travel_most_m,
        "chosen: from a submap's origin its robot is never farther; a saved state that says so is "
        "damaged");
  visit("between_drives_s", n.between_drives_s,
        "chosen: on the map's clock a drive begins so long after the one before it ended");
  visit("beside_m", n.beside_m,
        "chosen: so far beside all of the path a drive begins whose place is not known yet; the "
        "same is its uncertainty at least");
  visit("updates_most", n.updates_most, "chosen: of updates that nobody takes, so many are kept");
}

/// Turns a stream of sensor messages into a trajectory, a pose graph and a map, and tells where the
/// robot is while it drives.
///
///   Mapper mapper(robot, options, threads);
///   while (auto message = source.next()) {                        // a log, or sensors
///     mapper.add(*message);
///     while (auto update = mapper.next_update()) drive(update->map_T_robot());
///   }
///   MapResult result = mapper.finish();
///
/// Messages may come live. The clock is that of their stamps:
///   - A scan waits until odometry of its time or later has come, so that the motion up to it is
///     known; at most 0.25 s, counted by the newest stamp of any message. A stream that begins with
///     a second without odometry and gyro has none: its scans wait no more, until some comes.
///   - Scans that come late are worked on in the order in which they come. Odometry is remembered
///     for 10 s: a scan that is up to so late gets the motion of its own time.
///   - Odometry that is not newer than the last of its kind is ignored. What comes for a scan that
///     was worked on without it no longer changes that scan.
///   - A sensor that stops is bridged by the others, and said so: status, events, breaks.
///
/// Threads: add(), next_update(), finish(), save_state() and restore_state() are called from one
/// thread at a time; snapshot() from any, at any time. The front end works inside add(), a fraction
/// of a millisecond a scan (some tens where a lost robot is looked for). Search for loops, the
/// graph and what follows from them live on a thread of their own, so add() waits for them only
/// when they have fallen behind by eight submaps.
///
/// The result is the same bytes for any number of threads, and whether or not anybody asks for
/// updates and snapshots. When a correction of the map shows in updates depends on how fast the
/// machine is.
class Mapper {
 public:
  /// Throws OptionsError with everything that is wrong with the options.
  /// \param threads  that search for loops and draw the final map, beside the front end's
  Mapper(const RobotModel& robot, const MapOptions& options, Threads threads = {});
  ~Mapper();

  /// Throws nothing for what a sensor may send; memory may run out.
  void add(const SensorMessage& message);

  /// The oldest update that was not handed out yet: one a scan, in their order. Of updates that
  /// nobody takes the newest thousand are kept.
  [[nodiscard]] std::optional<MapUpdate> next_update();

  /// The map as it is now: submaps and key scans at their present poses, closures, faults so far.
  /// Consistent: all of it is of one moment. Cost: microseconds a submap; the scans are shared.
  [[nodiscard]] MapSnapshot snapshot() const;

  /// Ends the drive so far: what is added next is of another one in the same building, which may
  /// begin anywhere in it, on a day of its own: stamps may be earlier or later, of another clock.
  /// It is mapped as a piece of the path of its own until it is recognised: then all is one map.
  /// Call it any number of times; a drive without scans is none.
  void begin_drive();

  /// What the drive tells of the robot's sensors, once the last message was added; nothing with
  /// MapOptions::calibration off. When the map is bent by them, it is to be made anew: to finish()
  /// this one, its last closures, drawing and judgement, is not worth the time
  /// (robot_correction.hpp).
  /// Nothing but finish() may follow. Cost: the back end's rest, and some 0.1 s.
  [[nodiscard]] Calibration judge_robot();

  /// Ends the recording: last closures, last solution, the final map of all scans. Call once. A map
  /// that is too large leaves all else and says so in `map_failure`.
  /// \param progress  told before each stage and while loops are closed, maybe from another thread
  ///                  but never from two at once; once it returns false the run is cancelled
  /// \param cancel    asked whenever progress is told. Cancelled, the last search for loops ends,
  ///                  what only refines or judges the map is left out, and the result is marked
  ///                  incomplete
  [[nodiscard]] MapResult finish(const ProgressCallback& progress = {},
                                 const std::stop_token& cancel = {});

  /// Ends the recording as finish() does, up to the solved graph: what an edit of the map begins
  /// with (map_editor.hpp). Call once, instead of finish(); nothing may follow.
  /// \param goes_on  asked while loops are closed; once it returns false the search ends
  [[nodiscard]] SettledMap settle(const std::function<bool()>& goes_on = {});

  /// What finish() brings into the graph beside the laser's own; not part of a saved state. What a
  /// key scan's intensities tell is lost where a run goes on from one.
  void set_graph_addition(GraphAddition addition);

  /// Everything that the messages so far have led to, as plain data (mapper_state.hpp). A new
  /// mapper of the same robot and options that is given it goes on to the same bytes. Returns once
  /// the front end is copied; the rest follows when the back end has come as far, on its thread.
  /// Updates that wait are not part of it.
  [[nodiscard]] std::future<MapperState> save_state();
  /// Before the first message. Throws UsageError when nothing can have led to this state with this
  /// mapper's options; the mapper is of no use then.
  void restore_state(MapperState state);

  [[nodiscard]] std::int64_t scans() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace loopstone
