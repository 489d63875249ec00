#include "slam/turning_beams.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {

namespace {

/// Share of the beams that both scans saw which have the range that a turn foretells; nothing: too
/// few.
std::optional<double> explained(const LaserScan& before, const LaserScan& after, double turn_rad) {
  const double circle = 2.0 * kPi / std::abs(before.angle_increment_rad);
  int seen = 0;
  int same = 0;
  for (std::size_t i = 0; i < after.ranges_m.size(); ++i) {
    const double now_m = static_cast<double>(after.ranges_m[i]);
    if (!std::isfinite(now_m)) continue;
    // What a robot that turned left has at its right now.
    double beam =
        (after.angle_rad(i) + turn_rad - before.angle_min_rad) / before.angle_increment_rad;
    beam -= circle * std::floor(beam / circle);
    const auto then = static_cast<std::size_t>(std::lround(beam));
    if (then >= before.ranges_m.size()) continue;
    const double then_m = static_cast<double>(before.ranges_m[then]);
    if (!std::isfinite(then_m)) continue;
    ++seen;
    const double most_m = std::max(kTurningBeams.same_m, kTurningBeams.same_share * now_m);
    if (std::abs(now_m - then_m) < most_m) ++same;
  }
  if (seen < kTurningBeams.fewest_beams) return {};
  return static_cast<double>(same) / static_cast<double>(seen);
}

/// A scan that later ones are compared with.
struct Earlier {
  const LaserScan* scan = nullptr;
  Pose2 odom_T_robot{};
};

/// What the newest scan and the latest one before it that the robot had turned enough since tell.
int vote_of(const std::deque<Earlier>& earlier, const Earlier& now) {
  for (auto before = earlier.rbegin(); before != earlier.rend(); ++before) {
    const Pose2 motion = before->odom_T_robot.inverse() * now.odom_T_robot;
    if (motion.translation().norm() > kTurningBeams.most_m ||
        std::abs(motion.yaw) > kTurningBeams.most_rad)
      return 0;
    if (std::abs(motion.yaw) >= kTurningBeams.least_rad)
      return told_turn(*before->scan, *now.scan, motion.yaw);
  }
  return 0;
}

}  // namespace

int told_turn(const LaserScan& before, const LaserScan& after, double turn_rad) {
  const auto same = explained(before, after, turn_rad);
  const auto opposite = explained(before, after, -turn_rad);
  if (!same || !opposite || std::abs(*same - *opposite) < kTurningBeams.clear) return 0;
  return *same > *opposite ? 1 : -1;
}

bool TurnVotes::are_opposite() const {
  return same + opposite >= kTurningBeams.fewest_votes &&
         opposite >= kTurningBeams.opposite * (same + opposite);
}

bool TurnVotes::are_all_along(Duration drive) const {
  return first && (last - *first).seconds() >= kTurningBeams.all_along * drive.seconds();
}

TurnVotes turn_votes(std::span<const SubmapRecord> submaps, const std::deque<TrackedPose>& track,
                     int lidar) {
  TurnVotes votes;
  std::deque<Earlier> earlier;
  for (const SubmapRecord& submap : submaps) {
    submap.scans.for_each([&](const MappedScan& mapped) {
      if (mapped.scan.lidar != lidar || mapped.scan.angle_increment_rad == 0.0) return;
      if (mapped.index >= track.size() || !track[mapped.index].odom_T_robot) return;
      const Earlier now{&mapped.scan, *track[mapped.index].odom_T_robot};
      while (!earlier.empty() &&
             (mapped.scan.stamp - earlier.front().scan->stamp).seconds() > kTurningBeams.longest_s)
        earlier.pop_front();
      const int vote = vote_of(earlier, now);
      earlier.push_back(now);
      if (vote == 0) return;
      ++(vote > 0 ? votes.same : votes.opposite);
      if (!votes.first) votes.first = mapped.scan.stamp;
      votes.last = mapped.scan.stamp;
      earlier.clear();  // each turn counts once
    });
  }
  return votes;
}

}  // namespace loopstone
