#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/sensor/laser_scan.hpp"

namespace loopstone {

/// A scan that the final map is drawn from.
struct MappedScan {
  LaserScan scan{};
  std::size_t index = 0;  ///< among all scans
  Pose2 robot_T_lidar{};
  Pose2 local_T_robot{};
  Pose2 local_T_robot_end{};  ///< at the end of its sweep

  template <typename Archive>
  void archive(Archive& a) {
    a(scan, index, robot_T_lidar, local_T_robot, local_T_robot_end);
  }
};

/// Mapped scans, in stretches as KeyChain has them.
class ScanStore {
 public:
  void add(MappedScan scan, bool starts_stretch) {
    if (starts_stretch || stretches_.empty()) stretches_.emplace_back();
    stretches_.back().push_back(std::move(scan));
  }
  /// Only the first scan of the stretch stays.
  void thin(std::size_t stretch) {
    auto& scans = stretches_[stretch];
    scans.resize(1);
    scans.shrink_to_fit();
  }
  [[nodiscard]] std::size_t stretch_count() const { return stretches_.size(); }
  template <typename Visit>
  void for_each(Visit&& visit) const {
    for (const auto& stretch : stretches_) {
      for (const MappedScan& scan : stretch) visit(scan);
    }
  }

  template <typename Archive>
  void archive(Archive& a) {
    a(stretches_);
    if constexpr (Archive::kReads) {
      for (const auto& stretch : stretches_) a.check(!stretch.empty(), "a stretch without a scan");
    }
  }

 private:
  std::vector<std::vector<MappedScan>> stretches_{};
};

}  // namespace loopstone
