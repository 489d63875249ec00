#pragma once

#include <deque>
#include <optional>
#include <span>

#include "loopstone/sensor/laser_scan.hpp"
#include "loopstone/slam/submap_record.hpp"
#include "loopstone/slam/tracked_pose.hpp"

namespace loopstone {

/// By what two scans tell which way a robot turned.
struct TurningBeamsNumbers {
  double least_rad = 0.15;
  double most_rad = 0.8;
  double most_m = 0.2;
  double longest_s = 1.0;
  double same_m = 0.1;
  double same_share = 0.02;
  int fewest_beams = 20;
  double clear = 0.2;
  int fewest_votes = 6;
  double opposite = 0.9;
  double all_along = 0.5;
};
inline constexpr TurningBeamsNumbers kTurningBeams{};

template <typename Visitor>
void visit_numbers(const TurningBeamsNumbers& n, Visitor&& visit) {
  visit("least_rad", n.least_rad, "chosen: a turn by less hardly changes a scan");
  visit("most_rad", n.most_rad,
        "chosen: after a turn by more half a circle shows little of what "
        "it showed");
  visit("most_m", n.most_m, "chosen: who drove farther sees other ranges than before");
  visit("longest_s", n.longest_s, "chosen: people walk through what comes later");
  visit("same_m", n.same_m, "chosen: ranges that differ by less are the same");
  visit("same_share", n.same_share, "chosen: or by less than this share of them");
  visit("fewest_beams", n.fewest_beams, "chosen: of two scans; fewer are too much alike");
  visit("clear", n.clear,
        "chosen: share of the beams that one way must explain beyond the other to count");
  visit("fewest_votes", n.fewest_votes,
        "chosen: turns that tell clearly, one in a hundred of them wrongly; fewer may be chance");
  visit("opposite", n.opposite,
        "chosen: share of them that must say that the beams go round the "
        "other way");
  visit("all_along", n.all_along,
        "chosen: share of the drive between the first and the last of them; odometry that is "
        "wrong for a while is no laser upside down");
}

/// Which way a robot turned between two scans at one place: +1 as it is told, -1 the other way, 0
/// when they do not tell. Ranges alone are compared, no pose is asked.
/// \param turn_rad  counter-clockwise, from `before` to `after`
/// Cost: O(beams).
[[nodiscard]] int told_turn(const LaserScan& before, const LaserScan& after, double turn_rad);

/// How often the scans of a laser turned as odometry did, and how often the other way.
struct TurnVotes {
  int same = 0;
  int opposite = 0;
  std::optional<Stamp> first{};
  Stamp last{};

  /// By enough turns.
  [[nodiscard]] bool are_opposite() const;
  /// Over most of a drive.
  [[nodiscard]] bool are_all_along(Duration drive) const;
};

/// Of a whole drive. It needs no map: in halls and outdoors, where scans are few, a laser whose
/// beams go the other way is never placed by what it sees.
/// \param lidar  LaserScan::lidar
/// Cost: O(scans * beams).
[[nodiscard]] TurnVotes turn_votes(std::span<const SubmapRecord> submaps,
                                   const std::deque<TrackedPose>& track, int lidar);

}  // namespace loopstone
