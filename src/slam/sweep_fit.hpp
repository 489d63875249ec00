#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/sensor/laser_scan.hpp"
#include "loopstone/slam/submap_record.hpp"
#include "loopstone/slam/tracked_pose.hpp"

namespace loopstone {

/// What the search for a sweep that no log tells decides by.
struct SweepNumbers {
  int partners = 30;
  double partner_m = 1.0;
  double partner_rad = 1.0;
  double differ_rad_s = 0.1;
  double velocity_s = 0.05;
  double longest_velocity_s = 1.0;
  double steady_share = 0.5;
  double steady_rad_s = 0.3;
  double steady_m_s = 0.3;
  int stretches = 40;
  int pairs_of_stretch = 3;
  int fewest_pairs = 20;
  double range_max_m = 30.0;
  int points = 300;
  double pair_m = 0.3;
  double last_pair_m = 0.1;
  double same_normal = 0.9;
  int fewest_points = 40;
  int steps = 8;
  double prior_m = 0.1;
  double prior_rad = 0.1;
  int rounds = 6;
  double settled_s = 1e-4;
  double share_in_doubt = 0.01;
  double known_s = 0.005;
  double sigmas = 5.0;
  double least_s = 0.01;
  double half_agrees = 0.5;
  double longest_periods = 1.25;
};
inline constexpr SweepNumbers kSweep{};

template <typename Visitor>
void visit_numbers(const SweepNumbers& n, Visitor&& visit) {
  visit("partners", n.partners, "chosen: scans mapped shortly before, one of which is compared");
  visit("partner_m", n.partner_m, "chosen: from so near both see the same surfaces");
  visit("partner_rad", n.partner_rad, "chosen: likewise");
  visit("differ_rad_s", n.differ_rad_s,
        "chosen: two scans of robots that turn alike are bent alike, and tell nothing");
  visit("velocity_s", n.velocity_s, "chosen: a velocity is taken over so long at least, each way");
  visit("longest_velocity_s", n.longest_velocity_s, "chosen: a longer time bridges a gap");
  visit(
      "steady_share", n.steady_share,
      "chosen: velocities before and after a scan that differ by more than this share of both are "
      "no velocity: late stamps, a gap, a corrected pose");
  visit("steady_rad_s", n.steady_rad_s, "chosen: or by more than wheels change it within 0.1 s");
  visit("steady_m_s", n.steady_m_s, "chosen: as steady_rad_s");
  visit("stretches", n.stretches, "chosen: of the log, each of which is asked");
  visit("pairs_of_stretch", n.pairs_of_stretch,
        "chosen: of each stretch, those that turn most differently; more are not more certain");
  visit("fewest_pairs", n.fewest_pairs, "chosen: fewer are no basis for a judgement");
  visit("range_max_m", n.range_max_m, "chosen: farther surfaces are too few and too thin");
  visit("points", n.points, "chosen: of a scan; its surfaces are straight between them");
  visit("pair_m", n.pair_m, "chosen: a sweep bends by so much at first");
  visit("last_pair_m", n.last_pair_m, "chosen: when it is nearly straight");
  visit("same_normal", n.same_normal, "chosen: cosine between normals of one surface: 26 degrees");
  visit("fewest_points", n.fewest_points, "chosen: fewer are another place");
  visit("steps", n.steps, "chosen: an alignment settles within five");
  visit("prior_m", n.prior_m, "chosen: the front end's motion between both is not off by more");
  visit("prior_rad", n.prior_rad, "chosen: likewise");
  visit("rounds", n.rounds, "chosen: of straightening anew; it settles within four");
  visit("settled_s", n.settled_s, "chosen: less is not worth another round");
  visit("share_in_doubt", n.share_in_doubt,
        "chosen: velocities are means over the time between scans, and their errors those of all "
        "pairs");
  visit("known_s", n.known_s,
        "chosen: known to five milliseconds, it is observable; a robot that turns 30 degrees a "
        "second turns by 0.15 degrees meanwhile");
  visit("sigmas", n.sigmas, "chosen: less may be chance");
  visit("least_s", n.least_s,
        "chosen: less bends a scan of a robot that turns 30 degrees a second by 0.3 degrees: the "
        "resolution of the laser");
  visit("half_agrees", n.half_agrees,
        "chosen: each half of the log must ask for this share of the sweep at least");
  visit("longest_periods", n.longest_periods,
        "chosen: no sweep takes longer than it is to the next one, but for the stamps' errors");
}

/// A scan and how the robot moved.
struct MovingScan {
  const LaserScan* scan = nullptr;
  Pose2 robot_T_lidar{};
  Pose2 local_T_robot{};
  Tangent2 velocity = Tangent2::Zero();  ///< of the robot, about the scan [m/s, m/s, rad/s]
};

/// The scans of one laser that do not tell their sweep, with the velocities that the track tells;
/// those without a steady one are left out.
/// They point into `submaps`. \param lidar  LaserScan::lidar
[[nodiscard]] std::vector<MovingScan> untold_scans(std::span<const SubmapRecord> submaps,
                                                   const std::deque<TrackedPose>& track, int lidar);

/// The time from first beam to last, as the scans themselves tell.
struct SweepFit {
  double sweep_s = 0.0;  ///< negative: the last beam comes first
  double sigma_s = 0.0;  ///< one standard deviation
  std::size_t pairs = 0;
  bool halves_agree = false;

  [[nodiscard]] bool is_known() const { return pairs > 0 && sigma_s < kSweep.known_s; }
  [[nodiscard]] bool is_off() const;
};

/// Scans of the same surfaces that were taken while the robot turned differently are bent
/// differently by a sweep, and no motion between them explains that. Of each pair the motion is
/// free, so that neither odometry nor the front end's poses matter, and stamps that are late don't.
/// Nothing when there are too few such pairs.
/// Cost: some 0.5 ms for each of at most 120 pairs, and four times that where there is a sweep.
[[nodiscard]] std::optional<SweepFit> fit_sweep(std::span<const MovingScan> scans);

}  // namespace loopstone
