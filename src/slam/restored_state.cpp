// Whether what comes from a file hangs together: every index lies inside what it points into. A run
// that goes on from a state where one does not would read what is not there.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "loopstone/slam/back_end.hpp"
#include "loopstone/slam/drive_record.hpp"
#include "loopstone/slam/front_end.hpp"
#include "loopstone/slam/mapper_state.hpp"

namespace loopstone {

namespace {

bool only_grow(std::span<const SubmapRecord> submaps) {
  double before_m = 0.0;
  return std::ranges::all_of(submaps, [&](const SubmapRecord& submap) {
    const double last_m = std::exchange(before_m, submap.travelled_m);
    return std::isfinite(submap.travelled_m) && submap.travelled_m >= last_m;
  });
}

/// Whether full submaps come first, and speak of each other alone.
bool are_in_order(std::span<const SubmapRecord> submaps, std::size_t full, double reach_m) {
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    const SubmapRecord& submap = submaps[i];
    if ((submap.state == SubmapState::kOpen) != (i >= full)) return false;
    if ((submap.frozen != nullptr) != (submap.state == SubmapState::kFrozen)) return false;
    if (submap.frozen && !submap.frozen->lies_within(reach_m)) return false;
    if (!std::ranges::all_of(submap.closed_with, [&](SubmapId id) { return id.index < full; }))
      return false;
  }
  return true;
}

/// Whether key scans and mapped scans come in order, key scans are those that say so, and every
/// stretch begins with one.
bool scans_fit(std::span<const SubmapRecord> submaps, std::size_t scans) {
  std::optional<std::size_t> last;
  for (const SubmapRecord& submap : submaps) {
    std::size_t key = 0;
    bool fits = !submap.keys.empty() && !submap.scans.empty();
    submap.scans.for_each([&](const MappedScan& mapped) {
      const bool is_key = key < submap.keys.size() && submap.keys[key].scan == mapped.index;
      if (is_key) ++key;
      fits = fits && (is_key || key > 0) && mapped.is_key == is_key && mapped.index < scans &&
             (!last || mapped.index > *last);
      last = mapped.index;
    });
    if (!fits || key != submap.keys.size()) return false;
  }
  return true;
}

/// Whether the scans that wait follow those that the back end has.
bool waiting_fit(std::span<const WaitingScan> waiting, std::span<const SubmapRecord> submaps,
                 std::size_t scans) {
  if (waiting.empty()) return true;
  std::optional<std::size_t> last;
  if (!submaps.empty())
    submaps.back().scans.for_each([&](const MappedScan& mapped) { last = mapped.index; });
  return (last || waiting.front().key) && std::ranges::all_of(waiting, [&](const WaitingScan& w) {
           if (w.scan == nullptr) return false;
           const std::size_t index = w.scan->index;
           const bool follows = index < scans && (!last || index > *last);
           last = index;
           return follows && w.scan->is_key == w.key.has_value() &&
                  (!w.key || w.key->scan == index);
         });
}

bool poses_are_sound(const SubmapRecord& submap) {
  return is_sound(submap.map_T_submap) && is_sound(submap.across.pose) &&
         std::ranges::all_of(submap.keys,
                             [](const KeyScan& key) { return is_sound(key.local_T_robot); });
}

bool track_is_sound(const std::deque<TrackedPose>& track, std::span<const PathBreak> breaks) {
  return std::ranges::all_of(
             track, [](const TrackedPose& pose) { return is_sound(pose.local_T_robot); }) &&
         std::ranges::all_of(breaks,
                             [&](const PathBreak& found) { return found.to_scan < track.size(); });
}

}  // namespace

bool is_sound(const Pose2& pose) {
  constexpr double kMostRad = 100.0;
  return std::isfinite(pose.x) && std::isfinite(pose.y) && std::abs(pose.yaw) <= kMostRad;
}

bool is_sound(const BackEnd::State& state, std::size_t scans, double reach_m) {
  const std::span<const SubmapRecord> submaps = state.chain.submaps;
  const auto open = std::ranges::find(submaps, SubmapState::kOpen, &SubmapRecord::state);
  const auto full = static_cast<std::size_t>(open - submaps.begin());
  return std::isfinite(state.chain.length_m + state.chain.breaks_m) && only_grow(submaps) &&
         are_in_order(submaps, full, reach_m) && scans_fit(submaps, scans) &&
         is_sound(state.loops, submaps.first(full)) &&
         std::ranges::all_of(submaps, poses_are_sound) &&
         std::ranges::all_of(state.closures, [&](const LoopClosure& closure) {
           return closure.from_submap.index < full && closure.to_submap.index < full &&
                  is_sound(closure.from_T_to);
         });
}

bool is_sound(const MapperState& state, double reach_m) {
  const MapperState::SoFar& so_far = state.so_far;
  const std::size_t scans = so_far.track.size();
  return is_sound(state.back_end, scans, reach_m) &&
         waiting_fit(state.waiting, state.back_end.chain.submaps, scans) &&
         so_far.gyro_scans >= 0 && so_far.submaps_frozen <= so_far.submaps_opened &&
         so_far.submaps_opened <= scans && so_far.lost_scans >= 0 &&
         static_cast<std::size_t>(so_far.lost_scans) <= scans &&
         track_is_sound(so_far.track, so_far.breaks);
}

bool is_sound(const DriveRecord& drive, double reach_m) {
  const std::vector<SubmapRecord>& submaps = drive.back_end.chain.submaps;
  return !submaps.empty() && !drive.track.empty() &&
         std::ranges::none_of(
             submaps, [](const SubmapRecord& s) { return s.state == SubmapState::kOpen; }) &&
         is_sound(drive.back_end, drive.track.size(), reach_m) && drive.gyro_scans >= 0 &&
         track_is_sound(drive.track, drive.breaks);
}

bool FrontEnd::submaps_lie_within(double reach_m) const {
  return std::ranges::all_of(active_, [&](const ActiveSubmap& active) {
    return active.submap.freeze().lies_within(reach_m);
  });
}

}  // namespace loopstone
