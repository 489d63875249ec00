#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "loopstone/slam/back_end.hpp"
#include "loopstone/slam/map_options.hpp"
#include "loopstone/slam/map_result.hpp"
#include "loopstone/slam/mapper_state.hpp"
#include "loopstone/slam/path_break.hpp"
#include "loopstone/slam/tracked_pose.hpp"

namespace loopstone {

/// A drive that was mapped by itself, as plain data: what it takes to join it to others of the same
/// building (JoinedDrives).
struct DriveRecord {
  /// Raised whenever a field of it, or of anything in it, changes.
  static constexpr std::uint32_t kVersion = 1;

  std::deque<TrackedPose> track{};  ///< every scan, by the drive's own clock
  std::vector<PathBreak> breaks{};
  MapStatistics statistics{};
  std::int64_t gyro_scans = 0;  ///< whose heading alone was known
  BackEnd::State back_end{};    ///< all submaps are full

  template <typename Archive>
  void archive(Archive& a) {
    a(track, breaks, statistics, gyro_scans, back_end);
  }
};

/// What a mapper of one drive has come to once its robot was judged (Mapper::judge_robot()),
/// without what only more scans would need. Throws UsageError for a state of several drives.
/// \param options  of the mapper
[[nodiscard]] DriveRecord record_of(MapperState state, const MapOptions& options);

/// Whether a record hangs together, as is_sound(MapperState) says; for what comes from a file.
[[nodiscard]] bool is_sound(const DriveRecord& drive, double reach_m);

}  // namespace loopstone
