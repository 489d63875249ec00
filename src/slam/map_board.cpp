#include "slam/map_board.hpp"

#include <algorithm>
#include <iterator>

#include "loopstone/slam/map_result.hpp"
#include "slam/odometry_warnings.hpp"
#include "slam/sensor_faults.hpp"

namespace loopstone {

namespace {

/// Of events that nobody takes, so many are kept.
constexpr std::size_t kMostEvents = 4096;

/// What the front end has added since the view: to its last submap, and new ones.
class OpenSubmaps {
 public:
  OpenSubmaps(std::vector<SubmapSnapshot>& submaps, const Pose2& map_T_local)
      : submaps_(submaps), map_T_local_(map_T_local) {}

  void add(const std::shared_ptr<const MappedScan>& scan, bool starts_submap) {
    if (starts_submap || submaps_.empty()) {
      close();
      submaps_.push_back({.id = {submaps_.size()},
                          .map_T_submap = map_T_local_ * scan->local_T_robot,
                          .map_T_local = map_T_local_});
    } else if (!scans_) {
      scans_ = std::make_shared<MappedScans>(*submaps_.back().scans);
    }
    if (!scans_) scans_ = std::make_shared<MappedScans>();
    scans_->push_back(scan);
  }
  void close() {
    if (scans_) submaps_.back().scans = std::move(scans_);
    scans_ = nullptr;
  }

 private:
  std::vector<SubmapSnapshot>& submaps_;
  Pose2 map_T_local_;
  std::shared_ptr<MappedScans> scans_{};
};

/// In the words of a finished map's warnings.
std::vector<std::string> warnings_of(const FaultView& faults) {
  if (!faults.first_scan) return {};
  MapResult so_far;
  so_far.trajectory.append(*faults.first_scan, {});
  so_far.odometry_episodes = faults.odometry;
  so_far.laser_episodes = faults.laser;
  std::vector<std::string> warnings = unused_scans(so_far);
  for (const auto& more : {sensor_faults(so_far), odometry_warnings(so_far)})
    warnings.insert(warnings.end(), more.begin(), more.end());
  return warnings;
}

}  // namespace

void MapBoard::add_scan(std::shared_ptr<const MappedScan> scan, bool starts_submap) {
  const std::lock_guard lock(mutex_);
  open_.push_back({std::move(scan), starts_submap});
}

void MapBoard::set_faults(FaultView faults) {
  auto shared = std::make_shared<const FaultView>(std::move(faults));
  const std::lock_guard lock(mutex_);
  faults_ = std::move(shared);
}

void MapBoard::publish(BackEndView view, std::vector<MapEvent> events) {
  auto shared = std::make_shared<const BackEndView>(std::move(view));
  const Pose2 map_T_local = shared->submaps.empty() ? Pose2{} : shared->submaps.back().map_T_local;
  const std::lock_guard lock(mutex_);
  while (open_from_ < shared->scans_taken && !open_.empty()) {
    open_.pop_front();
    ++open_from_;
  }
  open_from_ = shared->scans_taken;
  map_T_local_ = map_T_local;
  view_ = std::move(shared);
  std::move(events.begin(), events.end(), std::back_inserter(events_));
  if (events_.size() > kMostEvents)
    events_.erase(events_.begin(), events_.end() - static_cast<std::ptrdiff_t>(kMostEvents));
}

Pose2 MapBoard::map_T_local() const {
  const std::lock_guard lock(mutex_);
  return map_T_local_;
}

std::vector<MapEvent> MapBoard::take_events() {
  const std::lock_guard lock(mutex_);
  return std::exchange(events_, {});
}

MapSnapshot MapBoard::snapshot() const {
  std::unique_lock lock(mutex_);
  const auto view = view_;
  const auto open = open_;
  const auto faults = faults_;
  const Pose2 map_T_local = map_T_local_;
  lock.unlock();

  MapSnapshot snapshot{.submaps = view->submaps};
  OpenSubmaps open_submaps(snapshot.submaps, map_T_local);
  for (const OpenScan& scan : open) open_submaps.add(scan.scan, scan.starts_submap);
  open_submaps.close();
  snapshot.closures = view->closures;
  snapshot.odometry_episodes = faults->odometry;
  snapshot.laser_episodes = faults->laser;
  snapshot.breaks = faults->breaks;
  snapshot.warnings = warnings_of(*faults);
  return snapshot;
}

}  // namespace loopstone
