#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/formats/topic_options.hpp"
#include "loopstone/geometry/pose3.hpp"
#include "loopstone/messages/message_types.hpp"
#include "loopstone/sensor/laser_scan.hpp"

// Scans as messages hold them become ours.

namespace loopstone {

/// What had to be mended in the scans of one laser, and how often.
class ScanRemarks {
 public:
  void add(const std::string& what) { ++counts_[what]; }
  [[nodiscard]] const std::map<std::string, std::int64_t>& counts() const { return counts_; }

 private:
  std::map<std::string, std::int64_t> counts_{};
};

/// Ranges by REP-117; drivers older than that report what is beyond their reach as range_max or
/// more, and errors as values below range_min. The stamp is the message's.
/// \param period_s  usual time from scan to scan, 0 when unknown: a sweep that takes longer is not
///                  believed
/// Throws MessageError for a scan that can't be used.
[[nodiscard]] LaserScan to_laser_scan(const msg::LaserScan& message, double period_s,
                                      ScanRemarks& remarks);
/// The same of scans with several echoes a beam.
[[nodiscard]] LaserScan to_laser_scan(const msg::MultiEchoLaserScan& message, EchoUse echo,
                                      double period_s, ScanRemarks& remarks);
/// As the message that it would be.
[[nodiscard]] msg::LaserScan to_message(const LaserScan& scan, const std::string& frame);

/// Puts a scan where its laser sat: robot_T_lidar, and beams that run the other way when it hangs
/// upside down.
void place(const Pose3& base_T_laser, LaserScan& scan);

/// A planar scan made of a cloud: what lies between two heights, seen from above, in beams of half
/// a degree, each the nearest of its points. Its frame has the robot's directions and stands where
/// the scanner does. When the points have times of their own, the first beam is the earliest and
/// time_increment_s follows from them.
/// \param base_T_laser  z up from the floor
/// Throws MessageError for a cloud without x, y, z.
[[nodiscard]] LaserScan slice(const msg::PointCloud2& cloud, const Pose3& base_T_laser,
                              const HeightRange& heights);

/// Half a metre about the scanner's own height, so that the rings of a scanner in space are in it
/// far away, but not the floor; where the scanner's height is not known, a fifth of a metre.
[[nodiscard]] HeightRange slice_about(const Pose3& base_T_laser);

}  // namespace loopstone
