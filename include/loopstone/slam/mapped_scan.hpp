#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/sensor/laser_scan.hpp"

namespace loopstone {

/// A scan that maps are drawn from.
struct MappedScan {
  LaserScan scan{};
  std::size_t index = 0;  ///< among all scans
  Pose2 robot_T_lidar{};
  Pose2 local_T_robot{};      ///< where the front end put it; local: smooth, drifts
  Pose2 local_T_robot_end{};  ///< at the end of its sweep
  bool is_key = false;

  template <typename Archive>
  void archive(Archive& a) {
    a(scan, index, robot_T_lidar, local_T_robot, local_T_robot_end, is_key);
  }
};

/// Scans in order. They never change; holders share them.
using MappedScans = std::vector<std::shared_ptr<const MappedScan>>;

/// Mapped scans that grow while others read what share() handed out, which never changes. A copy
/// shares them, too.
class SharedScans {
 public:
  SharedScans() = default;
  ~SharedScans() = default;
  SharedScans(const SharedScans& other) : scans_(other.scans_), is_shared_(true) {
    other.is_shared_ = true;
  }
  SharedScans& operator=(const SharedScans& other) {
    if (this == &other) return *this;
    scans_ = other.scans_;
    is_shared_ = other.is_shared_ = true;
    return *this;
  }
  SharedScans(SharedScans&&) noexcept = default;
  SharedScans& operator=(SharedScans&&) noexcept = default;

  void add(std::shared_ptr<const MappedScan> scan) {
    if (is_shared_ || !scans_)
      scans_ = scans_ ? std::make_shared<MappedScans>(*scans_) : std::make_shared<MappedScans>();
    is_shared_ = false;
    scans_->push_back(std::move(scan));
  }
  /// Only the first stays.
  void thin() {
    if (!empty()) scans_ = std::make_shared<MappedScans>(1, scans_->front());
    is_shared_ = false;
  }
  [[nodiscard]] bool empty() const { return !scans_ || scans_->empty(); }
  [[nodiscard]] std::size_t size() const { return scans_ ? scans_->size() : 0; }
  /// Null when there are none.
  [[nodiscard]] std::shared_ptr<const MappedScans> share() const {
    is_shared_ = true;
    return scans_;
  }
  template <typename Visit>
  void for_each(Visit&& visit) const {
    if (!scans_) return;
    for (const auto& scan : *scans_) visit(*scan);
  }

  template <typename Archive>
  void archive(Archive& a) {
    std::vector<MappedScan> read;
    if constexpr (Archive::kReads) {
      a(read);
      *this = {};
      for (MappedScan& scan : read) add(std::make_shared<const MappedScan>(std::move(scan)));
    } else {
      a(static_cast<std::uint64_t>(size()));
      for_each([&a](const MappedScan& scan) { a(scan); });
    }
  }

 private:
  std::shared_ptr<MappedScans> scans_{};
  mutable bool is_shared_ = false;
};

}  // namespace loopstone
