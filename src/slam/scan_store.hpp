#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/slam/map_snapshot.hpp"

namespace loopstone {

/// \param map_T_local  at the scan
[[nodiscard]] inline PosedScan posed(const MappedScan& mapped, const Pose2& map_T_local) {
  const Pose2 map_T_robot = map_T_local * mapped.local_T_robot;
  return {&mapped.scan, map_T_robot * mapped.robot_T_lidar,
          map_T_local * mapped.local_T_robot_end * mapped.robot_T_lidar, map_T_robot};
}

/// Mapped scans, in stretches as KeyChain has them: a stretch begins with the first scan of a
/// submap. What share() handed out never changes.
class ScanStore {
 public:
  void add(std::shared_ptr<const MappedScan> scan, bool starts_stretch) {
    if (starts_stretch || stretches_.empty()) {
      stretches_.push_back(std::make_shared<MappedScans>());
      last_is_shared_ = false;
    } else if (last_is_shared_) {
      stretches_.back() = std::make_shared<MappedScans>(*stretches_.back());
      last_is_shared_ = false;
    }
    stretches_.back()->push_back(std::move(scan));
    ++added_;
  }
  /// Only the first scan of the stretch stays.
  void thin(std::size_t stretch) {
    stretches_[stretch] = std::make_shared<MappedScans>(1, stretches_[stretch]->front());
  }
  [[nodiscard]] std::size_t stretch_count() const { return stretches_.size(); }
  /// How many were ever added.
  [[nodiscard]] std::size_t added() const { return added_; }
  [[nodiscard]] std::vector<std::shared_ptr<const MappedScans>> share() {
    last_is_shared_ = true;
    return {stretches_.begin(), stretches_.end()};
  }
  template <typename Visit>
  void for_each(Visit&& visit) const {
    for (const auto& stretch : stretches_) {
      for (const auto& scan : *stretch) visit(*scan);
    }
  }

  template <typename Archive>
  void archive(Archive& a) {
    if constexpr (Archive::kReads) {
      std::vector<std::vector<MappedScan>> plain;
      a(plain);
      stretches_.clear();
      added_ = 0;
      for (auto& scans : plain) {
        a.check(!scans.empty(), "a stretch without a scan");
        auto stretch = std::make_shared<MappedScans>();
        for (MappedScan& scan : scans)
          stretch->push_back(std::make_shared<const MappedScan>(std::move(scan)));
        added_ += stretch->size();
        stretches_.push_back(std::move(stretch));
      }
    } else {
      a(static_cast<std::uint64_t>(stretches_.size()));
      for (const auto& stretch : stretches_) {
        a(static_cast<std::uint64_t>(stretch->size()));
        for (const auto& scan : *stretch) a(*scan);
      }
    }
  }

 private:
  std::vector<std::shared_ptr<MappedScans>> stretches_{};
  bool last_is_shared_ = false;
  std::size_t added_ = 0;
};

}  // namespace loopstone
