#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/base/progress.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/sensor/robot_model.hpp"
#include "loopstone/slam/drive_record.hpp"
#include "loopstone/slam/loop_closer.hpp"
#include "loopstone/slam/loop_closure.hpp"
#include "loopstone/slam/map_options.hpp"
#include "loopstone/slam/map_result.hpp"
#include "loopstone/slam/settled_map.hpp"

namespace loopstone {

struct DriveSeat;
struct LaidDrive;

/// What was found and tried between two drives, or within one. Submaps are counted within their
/// drives; `from` and `older` are of the older drive.
struct DrivePair {
  std::size_t older = 0;  ///< drives, in their order
  std::size_t newer = 0;
  std::vector<LoopClosure> closures{};
  std::map<SubmapPair, Pose2> tried{};
  std::set<SubmapPair> tried_by_appearance{};
  std::map<SubmapPair, std::vector<bool>> seen{};

  [[nodiscard]] int standing() const;

  /// Of two drives that are known to whoever keeps it.
  template <typename Archive>
  void archive(Archive& a) {
    a(closures, tried, tried_by_appearance, seen);
  }
};

/// Where a drive lies among the others.
struct DrivePlacement {
  std::vector<Pose2> map_T_submaps{};
  std::vector<bool> covered{};  ///< of each submap: older ones show all of it
  bool is_joined = false;       ///< with the most others, by closures

  template <typename Archive>
  void archive(Archive& a) {
    a(map_T_submaps, covered, is_joined);
  }
};

/// What one drive saw: its scans where they lie on the map, and the map that they alone make.
struct DriveVisit {
  std::size_t drive = 0;  ///< among those that are joined
  std::span<const PosedScan> scans{};
  OccupancyMap map{};
};
using TakeVisit = std::function<void(const DriveVisit& visit)>;

/// Drives of one building, each mapped by itself, that become one map: each is recognised on what
/// the others saw, without a guess, as Mapper::begin_drive() has it. What is known of them is plain
/// data, so that it can be kept, and a drive be added another day.
///
/// A drive is recognised where one place of it fits one place of the map and no other one, the
/// place is like no other one of its own map, the places around bear it out, and a second closure
/// asks for the same; and where all that both saw of the place lies on each other to within
/// centimetres (drive_ties.hpp). Until then it waits beside the map; a later drive may tie it.
///
/// The result depends on the drives and their order alone. Not thread-safe.
class JoinedDrives {
 public:
  /// Throws OptionsError with everything that is wrong with the options.
  JoinedDrives(const MapOptions& options, Threads threads);

  /// Drives as they are known already, and what was found between them.
  /// Throws UsageError where they contradict each other.
  void restore(std::vector<std::shared_ptr<const DriveRecord>> drives, std::vector<DrivePair> pairs,
               std::vector<DrivePlacement> placements);

  /// Looks for a drive among those before it, and for what it brings together.
  /// \param goes_on  asked now and then; once it returns false the search ends, and what it found
  ///                 until then is no result to keep
  /// Cost: about 10 ms for each pair of submaps, of which one is the drive's and the other not
  /// covered by older ones; until the drive is recognised.
  void add(std::shared_ptr<const DriveRecord> drive, const std::function<bool()>& goes_on = {});

  [[nodiscard]] std::size_t size() const { return drives_.size(); }
  [[nodiscard]] const std::vector<DrivePair>& pairs() const { return pairs_; }
  [[nodiscard]] const std::vector<DrivePlacement>& placements() const { return placements_; }
  [[nodiscard]] const DriveRecord& record(std::size_t drive) const { return *drives_[drive]; }
  [[nodiscard]] bool is_joined(std::size_t drive) const { return placements_[drive].is_joined; }

  /// Whether there is something of a drive that none before it shows: others are compared with it.
  [[nodiscard]] bool shows_something_alone(std::size_t drive) const;

  /// Forgets a drive and all that rests on it. What it showed alone is compared again among the
  /// others; else that costs next to nothing.
  void remove(std::size_t drive);

  /// What maps are drawn from, of the drives that are joined, counted and stamped as finish() has
  /// it. Cost: that of copying the scans.
  [[nodiscard]] MappedScans scans() const;

  /// The map of those drives that are joined, finished as Mapper::finish() does. Scans are counted
  /// and stamped one drive after the other: MapResult::drives.
  /// \param robot  whose footprint frees the cells that it crosses
  /// \param take_visit  is given what each drive saw, in order; then the result has no map. Empty:
  ///                    it is that of all scans
  /// \param progress    told of each step; false: the result is not complete
  [[nodiscard]] MapResult finish(const RobotModel& robot, const TakeVisit& take_visit = {},
                                 const ProgressCallback& progress = {}) const;

 private:
  [[nodiscard]] BackEnd::State assemble() const;
  [[nodiscard]] JoinedDrives joined_alone() const;
  [[nodiscard]] MapResult finish_all(const RobotModel& robot, const TakeVisit& take_visit,
                                     const ProgressCallback& progress) const;
  void take_apart(const BackEnd::State& state);
  bool untie(const std::vector<std::size_t>& before);
  [[nodiscard]] bool show_one_place(const std::vector<std::size_t>& sets, std::size_t one,
                                    std::size_t other) const;
  [[nodiscard]] LaidDrive laid(std::size_t drive) const;
  void draw_visits(std::span<const PosedScan> scans, std::span<const DriveSeat> seats,
                   double footprint_m, const TakeVisit& take_visit,
                   const ProgressCallback& goes_on) const;

  MapOptions options_;
  Threads threads_;
  std::vector<std::shared_ptr<const DriveRecord>> drives_{};
  std::vector<DrivePair> pairs_{};
  std::vector<DrivePlacement> placements_{};
};

}  // namespace loopstone
