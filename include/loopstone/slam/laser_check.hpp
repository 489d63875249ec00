#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/sensor/laser_scan.hpp"
#include "loopstone/slam/motion_predictor.hpp"

namespace loopstone {

/// What is wrong with the laser, as far as its scans tell.
enum class LaserFault {
  kBlocked,  ///< nearly all returns come from right in front of it
  kFrozen,   ///< the same scan to the last bit, while odometry says that the robot moves
};

[[nodiscard]] std::string_view to_string(LaserFault fault);

/// A time during which scans said nothing of the surroundings.
struct LaserEpisode {
  LaserFault fault = LaserFault::kBlocked;
  Stamp from{};  ///< of the first scan that shows it
  Stamp to{};    ///< of the last one
  std::size_t scans = 0;
  double odometry_m = 0.0;    ///< travelled meanwhile, as odometry has it
  double odometry_rad = 0.0;  ///< turned

  template <typename Archive>
  void archive(Archive& a) {
    a(fault, from, to, scans, odometry_m, odometry_rad);
  }
};

/// Tells scans that show the laser's cover, or are one scan again and again, from those that show
/// the surroundings.
///
/// A robot that stands still in a world without noise repeats itself too; so a scan counts as
/// frozen only once odometry has moved since the scan that it repeats. Without odometry nothing
/// tells the two apart; then repetition is counted and not judged.
/// Cost: one pass over the ranges. Deterministic.
class LaserCheck {
 public:
  /// Whether the scan can be believed. \param odometry  at its stamp, if there is any
  [[nodiscard]] bool add(const LaserScan& scan, const std::optional<OdometryReading>& odometry);

  [[nodiscard]] const std::vector<LaserEpisode>& episodes() const { return episodes_; }
  /// Whether the last episode goes on.
  [[nodiscard]] bool is_faulty() const { return open_; }
  /// Most scans in a row that were the same to the last bit while no odometry told whether the
  /// robot stood, the first one not counted.
  [[nodiscard]] std::size_t most_repeated() const { return most_repeated_; }

  template <typename Archive>
  void archive(Archive& a) {
    a(episodes_, last_ranges_m_, repeated_since_, repeated_, most_repeated_, open_, begun_);
  }

 private:
  [[nodiscard]] std::optional<LaserFault> fault_of(const LaserScan& scan,
                                                   const std::optional<OdometryReading>& odometry);
  [[nodiscard]] bool is_frozen(const LaserScan& scan,
                               const std::optional<OdometryReading>& odometry);

  std::vector<LaserEpisode> episodes_{};
  std::vector<float> last_ranges_m_{};
  std::optional<OdometryReading> repeated_since_{};  ///< at the scan that is repeated
  std::size_t repeated_ = 0;
  std::size_t most_repeated_ = 0;
  bool open_ = false;                       ///< the last episode goes on
  std::optional<OdometryReading> begun_{};  ///< odometry when it began
};

}  // namespace loopstone
