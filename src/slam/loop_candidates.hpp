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

namespace loopstone {

/// Two places that look alike are laid centre on centre, give or take what each one saw more of on
/// one side.
inline constexpr double kPlaceHalfM = 5.0;

/// What loop closing keeps of a submap.
struct LoopSubmap {
  FrozenSubmap submap{};
  std::size_t piece = 0;
  double travelled_m = 0.0;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< of its surfaces, submap frame
  double radius_m = 0.0;                             ///< rms distance of its surfaces from it
  std::vector<SubmapId> closed_with{};
  std::vector<float> descriptor{};  ///< of the place, once somebody asked; follows from the submap
  bool dropped = false;

  template <typename Archive>
  void archive(Archive& a) {
    a(submap, piece, travelled_m, centre, radius_m, closed_with, dropped);
  }
};

[[nodiscard]] LoopSubmap loop_submap(FinishedSubmap submap, double travelled_m);

/// Two submaps that may show one place, and where to look.
struct LoopCandidate {
  SubmapId older{};
  SubmapId newer{};
  Pose2 older_T_newer{};  ///< at the present poses; of a pair by appearance, centre on centre
  double half_xy_m = 0.0;
  double half_yaw_rad = 0.0;
  double distance_m = 0.0;
  bool by_appearance = false;
};

/// Shortest travel from a submap to each other: Dijkstra, neighbours in sequence by the path
/// between them, closures at a fixed price. Infinite beyond `enough_m`.
[[nodiscard]] std::vector<double> travel_from(std::span<const LoopSubmap> submaps, SubmapId from,
                                              double enough_m);

/// Older submaps that a newer one may be compared with.
struct LoopCandidates {
  std::vector<LoopCandidate> near{};  ///< where the window holds what drift explains, nearest first
  std::vector<LoopCandidate> far{};   ///< where drift may exceed the largest window
};

/// \param skips  pairs that need no comparing: closed already
[[nodiscard]] LoopCandidates candidates_for(std::span<const LoopSubmap> submaps, SubmapId newer,
                                            std::span<const Pose2> map_T_submap,
                                            const LoopOptions& options,
                                            const std::function<bool(SubmapId older)>& skips);

/// The few of the far ones whose place descriptors are nearest, best first. Which these are does
/// not depend on poses. Describes submaps that were not described yet.
[[nodiscard]] std::vector<LoopCandidate> most_alike(std::vector<LoopSubmap>& submaps,
                                                    SubmapId newer,
                                                    std::span<const LoopCandidate> far, int most);

}  // namespace loopstone
