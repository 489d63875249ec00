#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "mapping/glass_evidence.hpp"

namespace loopstone {

/// A piece of surface, 10 cm long, and how it was looked at.
struct LookedAtPiece {
  Eigen::Vector2f position;  ///< [m], map frame
  Eigen::Vector2f normal;    ///< unit, to the side it was seen from
  std::vector<SurfaceLook> looks{};
};

/// Pieces of all surfaces that a drive saw and did not drive over, with what each beam tells of
/// them: it ended there, or went through where the piece is and ended well behind it. Of pieces at
/// edges there are no looks.
/// \param scans               in time order; thinned as assess_map() thins them
/// \param footprint_radius_m  of the robot
/// Deterministic: the same for any number of threads. Cost: about 0.1 ms a judged scan.
[[nodiscard]] std::vector<LookedAtPiece> surface_looks(std::span<const PosedScan> scans,
                                                       double footprint_radius_m, Threads threads);

}  // namespace loopstone
