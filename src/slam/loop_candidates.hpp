#pragma once

#include <Eigen/Core>
#include <compare>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/mapping/submap.hpp"
#include "loopstone/slam/loop_closer.hpp"
#include "loopstone/slam/loop_closure.hpp"
#include "loopstone/slam/submap_record.hpp"

namespace loopstone {

/// Which submaps may show one place.
struct LoopCandidatesNumbers {
  std::size_t neighbours = 2;
  double rest_m = 0.35;
  double rest_rad = 0.06;
  double half_yaw_most_rad = 0.8;
  double closure_travel_m = 1.0;
  double near_radii = 0.7;
  double place_half_m = 5.0;
  double unlike = 0.8;
  double break_sigmas = 2.0;
  double near_break_m = 20.0;
  double at_break_m = 10.0;
};
inline constexpr LoopCandidatesNumbers kLoopCandidates{};

template <typename Visitor>
void visit_numbers(const LoopCandidatesNumbers& n, Visitor&& visit) {
  visit("neighbours", n.neighbours,
        "chosen: submaps this close in sequence on one piece of the path share scans or are tied "
        "tightly already");
  visit("rest_m", n.rest_m, "chosen: uncertainty where two places are connected directly");
  visit("rest_rad", n.rest_rad, "chosen: the same of the heading");
  visit("half_yaw_most_rad", n.half_yaw_most_rad,
        "chosen: the window of headings grows no further; more is for appearance");
  visit("closure_travel_m", n.closure_travel_m,
        "chosen: travelling through a closure costs as much as this travel");
  visit("near_radii", n.near_radii,
        "chosen: two submaps nearer than this share of both their radii show parts of one place");
  visit("place_half_m", n.place_half_m,
        "chosen: two places that look alike are laid centre on centre, give or take what each one "
        "saw more of on one side");
  visit("unlike", n.unlike,
        "chosen: less alike than this share of the middle one of all that come into question is "
        "another place; of true pairs 19 in 20 were more alike");
  visit("break_sigmas", n.break_sigmas,
        "chosen: half of the window in which a place is looked for across a break: 95 % along one "
        "axis");
  visit("near_break_m", n.near_break_m,
        "chosen: so near to a break, before and after, what was seen may be the same in part");
  visit("at_break_m", n.at_break_m, "chosen: so near it is, wherever the submaps' centres lie");
}

/// Two submaps that may show one place, and where to look.
struct LoopCandidate {
  SubmapId older{};
  SubmapId newer{};
  Pose2 older_T_newer{};  ///< at the present poses; of a pair by appearance, centre on centre
  double half_xy_m = 0.0;
  double half_yaw_rad = 0.0;
  double distance_m = 0.0;
  bool by_appearance = false;
  bool either_way = false;    ///< also the older in the newer, of which it may be a part
  bool across_break = false;  ///< of two pieces of one drive that follow one another
};

/// Shortest travel from a submap to each other: Dijkstra, neighbours in sequence by the path
/// between them, closures at a fixed price. Infinite beyond `enough_m`.
[[nodiscard]] std::vector<double> travel_from(std::span<const SubmapRecord> submaps, SubmapId from,
                                              double enough_m);

/// Older submaps that a newer one may be compared with.
struct LoopCandidates {
  std::vector<LoopCandidate> near{};  ///< where the window holds what drift explains, nearest first
  std::vector<LoopCandidate> far{};   ///< where drift may exceed the largest window
  std::vector<LoopCandidate> adrift{};  ///< of drives that nothing ties yet: anywhere
};

/// \param skips  pairs that need no comparing: closed already
[[nodiscard]] LoopCandidates candidates_for(std::span<const SubmapRecord> submaps, SubmapId newer,
                                            const LoopOptions& options,
                                            const std::function<bool(SubmapId older)>& skips);

/// All of them, to be compared by appearance, either one in the other.
[[nodiscard]] std::vector<LoopCandidate> by_appearance(std::span<const SubmapRecord> submaps,
                                                       std::span<const LoopCandidate> candidates);

/// The few of the far ones whose place descriptors are nearest, best first. Which these are does
/// not depend on poses. Describes submaps that were not described yet.
[[nodiscard]] std::vector<LoopCandidate> most_alike(std::span<SubmapRecord> submaps, SubmapId newer,
                                                    std::span<const LoopCandidate> far, int most);

}  // namespace loopstone
